# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Gives our scripts a Docker engine and the base image where there are none. Source it after deploy/common.sh.

engine_pid=""

# engine_up: uses the engine that answers, or else starts one as root with its data in the cache folder.
engine_up() {
  deploy/install-packages container
  PATH="$PATH:/usr/sbin:/sbin"
  if docker info > /dev/null 2>&1; then return; fi
  if [ "$(id -u)" -ne 0 ]; then
    echo "No Docker engine answers ('docker info' tells why), and only root can start one." >&2
    return 1
  fi
  local run=/run/segserve-docker log="${cache_dir:?}/docker/dockerd.log" tries
  mkdir -p "$run" "$cache_dir/docker"
  dockerd --host "unix://$run/docker.sock" --data-root "$cache_dir/docker/data" --exec-root "$run/exec" \
    --pidfile "$run/dockerd.pid" > "$log" 2>&1 < /dev/null &
  engine_pid=$!
  export DOCKER_HOST="unix://$run/docker.sock"
  for ((tries = 0; tries < 150; tries++)); do
    if docker info > /dev/null 2>&1; then return; fi
    if ! kill -0 "$engine_pid" 2> /dev/null; then break; fi
    sleep 0.2
  done
  tail -n 20 "$log" >&2
  echo "dockerd did not start. Its log is $log" >&2
  return 1
}

# engine_down: ends the engine if engine_up started it.
engine_down() {
  if [ -z "$engine_pid" ]; then return; fi
  kill "$engine_pid" 2> /dev/null || true
  wait "$engine_pid" 2> /dev/null || true
  engine_pid=""
}

# base_image: makes debian:bookworm-slim from Debian's packages if the engine does not have it, since there may be no registry.
base_image() {
  if docker image inspect debian:bookworm-slim > /dev/null 2>&1; then return; fi
  local tar
  tar=$(mktemp --suffix=.tar)
  mmdebstrap --quiet --variant=minbase --include=ca-certificates bookworm "$tar" &&
    docker import "$tar" debian:bookworm-slim > /dev/null
  local result=$?
  rm -f "$tar"
  return $result
}
