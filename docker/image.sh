# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Builds the image of segserve. Source it after deploy/common.sh.

image_version() { sed -n 's/^project(segserve VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt; }

# Prints docker/Dockerfile with a stage "build" that takes the programs from the context.
dockerfile_with_binaries() {
  awk '/^FROM / { building = / AS build$/; print; if (building) print "COPY segserve segctl /"; next } !building' docker/Dockerfile
}

# build_image TAG FOLDER [BINARIES]: FOLDER is for what is in between. With BINARIES, a build folder of a Debian bookworm, the
# programs come from there; without, they are compiled in the image.
build_image() {
  local tag="$1" folder="$2" binaries="${3-}" context=. dockerfile=docker/Dockerfile
  if [ -n "$binaries" ]; then
    context="$folder/context" dockerfile="$folder/context/Dockerfile"
    mkdir -p "$context/deploy"
    cp LICENSE "$context"
    cp deploy/packages deploy/install-packages "$context/deploy"
    strip -o "$context/segserve" "$binaries/server/segserve"
    strip -o "$context/segctl" "$binaries/client/segctl"
    dockerfile_with_binaries > "$dockerfile"
  fi
  docker build --network=host --file "$dockerfile" --tag "$tag" --build-arg "VERSION=$(image_version)" \
    --build-arg "REVISION=$(git rev-parse HEAD)" "$context" > "$folder/build.log" 2>&1 || { tail -n 40 "$folder/build.log" >&2; return 1; }
}

# build_minimal_image TAG FOLDER PLATFORM VERSION REVISION: an image of nothing but FOLDER/layer.tar, which docker/minimal-files
# made. It says about itself what the image of docker/Dockerfile says. Nothing runs in it, so that PLATFORM may be that of another
# machine. Prints the digest of the layer, and the size.
build_minimal_image() {
  { printf 'FROM scratch\nADD layer.tar /\nENV PATH=/usr/local/bin\n'
    sed -n '/^ARG VERSION/,$p' docker/Dockerfile | sed '/image\.base\.name/d'; } > "$2/Dockerfile"
  docker build --platform "$3" --tag "$1" --build-arg "VERSION=$4" --build-arg "REVISION=$5" "$2" > "$2/minimal.log" 2>&1 ||
    { tail -n 40 "$2/minimal.log" >&2; return 1; }
  docker image inspect --format '{{index .RootFS.Layers 0}} {{.Size}} bytes' "$1"
}
