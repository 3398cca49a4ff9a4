# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Uses an image from outside, by segctl. Source it after deploy/common.sh and docker/engine.sh.

work=$(mktemp -d)
container=""
# What the container runs instead of the image's own command.
container_command=()
# The program on this machine.
segctl=""

clean_up() {
  if [ -n "$container" ]; then docker rm --force "$container" > /dev/null || true; fi
  engine_down
  rm -rf "$work"
}
trap clean_up EXIT

fail() { echo "$(basename "$(dirname "$0")")/$(basename "$0"): $*" >&2; return 1; }

# build_segctl FOLDER: takes segctl from this build folder, or else builds one.
build_segctl() {
  segctl="$1/client/segctl"
  if [ -x "$segctl" ]; then return; fi
  deploy/install-packages core service
  cmake --preset release -B build/demo -DSEGSERVE_BUILD_PCL=OFF -DSEGSERVE_BUILD_TESTS=OFF --log-level=WARNING
  cmake --build build/demo --target segctl
  segctl=build/demo/client/segctl
}

# start_container IMAGE OPTION..: sets `container`, `address` and `health_address` once it serves, and prints how long that took.
start_container() {
  local begin=$EPOCHREALTIME deadline=$((SECONDS + 30))
  container=$(docker run --detach --read-only --cap-drop ALL --security-opt no-new-privileges \
    --publish 127.0.0.1::50051 --publish 127.0.0.1::50052 "${@:2}" "$1" "${container_command[@]}")
  address=$(docker port "$container" 50051/tcp | head -n 1)
  health_address=$(docker port "$container" 50052/tcp | head -n 1)
  while [ $SECONDS -lt $deadline ]; do
    if "$segctl" health --server "$health_address" --service readiness --quiet 2> /dev/null; then
      awk -v a="$begin" -v b="$EPOCHREALTIME" 'BEGIN { printf "SERVING %.2f s after docker run\n", b - a }'
      return
    fi
    sleep 0.05
  done
  docker logs "$container" >&2
  fail "it does not serve after 30 s"
}

# segment_from_outside WIDTH HEIGHT: a scene of so many pixels.
segment_from_outside() {
  "$segctl" synth --seed 5 --width "$1" --height "$2" --output "$work/scene.pcd" --quiet
  "$segctl" segment "$work/scene.pcd" --server "$address" --output "$work/remote.pcd"
  "$segctl" segment "$work/scene.pcd" --local --output "$work/local.pcd" --quiet
  cmp "$work/remote.pcd" "$work/local.pcd" || fail "the labels differ from those of a run without server"
}

# stop_container: by SIGTERM; it must leave with 0, and say that it stopped.
stop_container() {
  local code
  docker kill --signal SIGTERM "$container" > /dev/null
  code=$(timeout 30 docker wait "$container") || fail "it did not stop within 30 s of SIGTERM"
  docker logs "$container" > "$work/log" 2>&1
  [ "$code" = 0 ] || { cat "$work/log" >&2; fail "it exited with $code after SIGTERM"; }
  grep -q ' stopped$' "$work/log" || { cat "$work/log" >&2; fail "its log does not say that it stopped"; }
  docker rm --force "$container" > /dev/null
  container=""
}
