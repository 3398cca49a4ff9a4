# shellcheck shell=bash
# What our scripts share; they run in the root of the repository.

# Everything that is worth keeping between runs and clones: compiled objects, the proto linter, other systems' libraries.
cache_dir="${XDG_CACHE_HOME:-$HOME/.cache}/segserve"

# ccache finds an object again in any clone: paths below the root count as relative.
export CCACHE_DIR="${CCACHE_DIR:-$cache_dir/ccache}" CCACHE_BASEDIR="$PWD" CCACHE_NOHASHDIR=1 CCACHE_MAXSIZE="${CCACHE_MAXSIZE:-2G}" CCACHE_SLOPPINESS=pch_defines,time_macros

# usage SCRIPT: the comment at its head.
usage() { awk 'NR > 1 { if (!/^#/) exit; sub(/^# ?/, ""); print }' "$1"; }

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

# start_server SEGSERVE FOLDER: starts the binary on a free loopback port, its log in FOLDER/server.log; sets server_pid and
# server_address once it serves.
start_server() {
  rm -f "$2/port"
  "$1" --listen 127.0.0.1:0 --port-file "$2/port" > "$2/server.log" 2>&1 < /dev/null &
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
