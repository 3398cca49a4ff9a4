# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Two machines on one: Docker engines in network namespaces of their own, joined by a cable (a veth pair), as nodes of a swarm.
# Source it after deploy/common.sh, as root. The caller's trap calls fleet_down.

readonly fleet_nodes=(a b)
readonly fleet_run=/run/segserve-fleet
declare -A fleet_pid=()

fleet_address() { if [ "$1" = a ]; then echo 10.77.0.1; else echo 10.77.0.2; fi; }

# on NODE COMMAND..: runs docker's client against the engine of that node.
on() { docker --host "unix://$fleet_run/$1/docker.sock" "${@:2}"; }

# fleet_up: both engines, joined in a swarm.
fleet_up() {
  deploy/install-packages container fleet
  PATH="$PATH:/usr/sbin:/sbin"
  if [ "$(id -u)" -ne 0 ]; then
    echo "Only root can make network namespaces and start Docker engines." >&2
    return 1
  fi
  if [ -e /run/netns/segserve-a ]; then
    echo "The network namespace segserve-a exists: another fleet runs, or one was not ended. 'ip netns delete segserve-a' removes it." >&2
    return 1
  fi
  local node
  for node in "${fleet_nodes[@]}"; do ip netns add "segserve-$node"; done
  ip link add cable netns segserve-a type veth peer name cable netns segserve-b
  for node in "${fleet_nodes[@]}"; do
    ip -n "segserve-$node" address add "$(fleet_address "$node")/24" dev cable
    ip -n "segserve-$node" link set cable up
    ip -n "segserve-$node" link set lo up
    start_node "$node"
  done
  on a swarm init --advertise-addr "$(fleet_address a)" > /dev/null
  on b swarm join --advertise-addr "$(fleet_address b)" --token "$(on a swarm join-token --quiet worker)" "$(fleet_address a):2377" > /dev/null
}

# start_node NODE: an engine with a network, mounts, a host name and processes of its own. Whatever runs on the node ends when its
# first process does, as after a loss of power.
start_node() {
  local node="$1" run="$fleet_run/$1" tries
  mkdir -p "$run" "${cache_dir:?}/fleet/$node"
  # shellcheck disable=SC2016 # the inner shell's own parameters
  nsenter --net="/run/netns/segserve-$node" unshare --mount --uts --pid --fork --kill-child --mount-proc bash -c '
    hostname "segserve-$1"
    mkdir -p /run/docker && mount -t tmpfs tmpfs /run/docker
    exec dockerd --host "unix://$2/docker.sock" --data-root "$3" --exec-root /run/docker/exec --pidfile /run/docker/dockerd.pid \
      --cgroup-parent "/segserve-$1"' bash "$node" "$run" "$cache_dir/fleet/$node" > "$run/dockerd.log" 2>&1 < /dev/null &
  fleet_pid[$node]=$!
  for ((tries = 0; tries < 150; tries++)); do
    if on "$node" info > /dev/null 2>&1; then return; fi
    if ! kill -0 "${fleet_pid[$node]}" 2> /dev/null; then break; fi
    sleep 0.2
  done
  tail -n 20 "$run/dockerd.log" >&2
  echo "The engine of node $node did not start. Its log is $run/dockerd.log" >&2
  return 1
}

# lose_node NODE: the node is gone at once, without a word to the others.
lose_node() {
  kill -KILL "${fleet_pid[$1]}"
  wait "${fleet_pid[$1]}" 2> /dev/null || true
  unset "fleet_pid[$1]"
}

# fleet_down: ends all that fleet_up started. What the engines have stored goes, too.
fleet_down() {
  local node tries
  for node in "${!fleet_pid[@]}"; do lose_node "$node"; done
  for node in "${fleet_nodes[@]}"; do
    ip netns delete "segserve-$node" 2> /dev/null || true
    rm -rf "${fleet_run:?}/$node"
    # Mounts of a lost node vanish a moment after it.
    for ((tries = 0; tries < 25; tries++)); do
      if rm -rf "${cache_dir:?}/fleet/$node" 2> /dev/null; then break; fi
      sleep 0.2
    done
  done
}
