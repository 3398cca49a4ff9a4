# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Functions that our scripts share; the scripts run in the root of the repository.

# Everything that is worth keeping between runs and clones: compiled objects, the proto linter, other systems' libraries.
cache_dir="${XDG_CACHE_HOME:-$HOME/.cache}/segserve"

# ccache finds an object again in any clone: paths below the root count as relative.
export CCACHE_DIR="${CCACHE_DIR:-$cache_dir/ccache}" CCACHE_BASEDIR="$PWD" CCACHE_NOHASHDIR=1 CCACHE_MAXSIZE="${CCACHE_MAXSIZE:-2G}" CCACHE_SLOPPINESS=pch_defines,time_macros

# usage SCRIPT: prints the comment at its head, without the license.
usage() { awk 'NR > 1 && !/SPDX/ { if (!/^#/) exit; sub(/^# ?/, ""); print }' "$1"; }

# stage NAME COMMAND..: runs it and remembers how long it took; stage_times prints all of them. Under `set -e` the command
# is not caught here, so that a shell function of several steps ends, with the script, at the first that fails.
stage_log=()
stage() {
  local name="$1" started=$EPOCHREALTIME
  shift
  echo "== $name"
  "$@"
  local result=$? seconds
  seconds=$(awk -v a="$started" -v b="$EPOCHREALTIME" 'BEGIN { printf "%.1f", b - a }')
  stage_log+=("$(printf '%8s s  %s%s' "$seconds" "$name" "$([ $result -eq 0 ] || echo "  (failed)")")")
  return $result
}
stage_times() { printf '%s\n' "${stage_log[@]}"; }

# with_progress LOG COMMAND..: runs a build by ninja, its output in LOG, and shows how far it is: on a terminal in one line that
# is rewritten, elsewhere by a line every 15 s. Its exit code; of a build that failed, the end of the log goes to standard error.
with_progress() {
  local log="$1" started=$SECONDS said=-15 step="" last=""
  shift
  "$@" > "$log" 2>&1 < /dev/null &
  local pid=$!
  while kill -0 "$pid" 2> /dev/null; do
    sleep 0.5
    step=$(tail -n 50 "$log" | grep -oE '^\[[0-9]+/[0-9]+\]' | tail -n 1 || true)
    if [ -z "$step" ] || [ "$step" = "$last" ]; then continue; fi
    if [ -t 1 ]; then
      printf '\r  %s %d s ' "$step" "$((SECONDS - started))"
      last="$step"
    elif [ $((SECONDS - said)) -ge 15 ]; then
      echo "  $step $((SECONDS - started)) s"
      last="$step" said=$SECONDS
    fi
  done
  if [ -t 1 ]; then printf '\r\033[K'; fi
  local result=0
  wait "$pid" || result=$?
  if [ $result -ne 0 ]; then
    tail -n 40 "$log" >&2
    echo "The build failed; all of its output is in $log" >&2
  fi
  return $result
}

# start_server SEGSERVE FOLDER [FLAG..]: starts the binary on a free loopback port, its log in FOLDER/server.log; sets server_pid
# and server_address once it serves.
start_server() {
  rm -f "$2/port"
  "$1" --listen 127.0.0.1:0 --port-file "$2/port" "${@:3}" > "$2/server.log" 2>&1 < /dev/null &
  server_pid=$!
  local tries
  for ((tries = 0; tries < 100; tries++)); do
    if [ -f "$2/port" ]; then
      # shellcheck disable=SC2034 # for the caller
      server_address="127.0.0.1:$(cat "$2/port")"
      return
    fi
    if ! kill -0 "$server_pid" 2> /dev/null; then break; fi
    sleep 0.1
  done
  cat "$2/server.log" >&2
  echo "$1 did not start" >&2
  return 1
}

# stop_server: ends what start_server started, by SIGTERM; its exit code.
stop_server() {
  if [ -z "${server_pid-}" ]; then return; fi
  local pid="$server_pid"
  server_pid=""
  kill "$pid" 2> /dev/null || true
  wait "$pid"
}
