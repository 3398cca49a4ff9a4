# shellcheck shell=bash
# What our scripts share; they run in the root of the repository.

# Everything that is worth keeping between runs and clones: compiled objects, the proto linter, other systems' libraries.
cache_dir="${XDG_CACHE_HOME:-$HOME/.cache}/segserve"

# ccache finds an object again in any clone: paths below the root count as relative.
export CCACHE_DIR="${CCACHE_DIR:-$cache_dir/ccache}" CCACHE_BASEDIR="$PWD" CCACHE_NOHASHDIR=1 CCACHE_MAXSIZE="${CCACHE_MAXSIZE:-2G}"

# usage SCRIPT: the comment at its head.
usage() { awk 'NR > 1 { if (!/^#/) exit; sub(/^# ?/, ""); print }' "$1"; }

# stage NAME COMMAND..: runs it and remembers how long it took; stage_times prints all of them.
stage_log=()
stage() {
  local name="$1" started=$EPOCHREALTIME
  shift
  echo "== $name"
  local result=0
  "$@" || result=$?
  local seconds
  seconds=$(awk -v a="$started" -v b="$EPOCHREALTIME" 'BEGIN { printf "%.1f", b - a }')
  stage_log+=("$(printf '%8s s  %s%s' "$seconds" "$name" "$([ $result -eq 0 ] || echo "  (failed)")")")
  return $result
}
stage_times() { printf '%s\n' "${stage_log[@]}"; }
