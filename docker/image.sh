# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Builds the image of segserve. Source it after deploy/common.sh.

# Prints docker/Dockerfile with a stage "build" that takes the programs from the context.
dockerfile_with_binaries() {
  awk '/^FROM / { building = / AS build$/; print; if (building) print "COPY segserve segctl /"; next } !building' docker/Dockerfile
}

# build_image TAG FOLDER [BINARIES]: FOLDER is for what is in between. With BINARIES, a build folder of a Debian bookworm, the
# programs come from there; without, they are compiled in the image.
build_image() {
  local tag="$1" folder="$2" binaries="${3-}" version context=. dockerfile=docker/Dockerfile
  version=$(sed -n 's/^project(segserve VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
  if [ -n "$binaries" ]; then
    context="$folder/context" dockerfile="$folder/context/Dockerfile"
    mkdir -p "$context/deploy"
    cp LICENSE "$context"
    cp deploy/packages deploy/install-packages "$context/deploy"
    strip -o "$context/segserve" "$binaries/server/segserve"
    strip -o "$context/segctl" "$binaries/client/segctl"
    dockerfile_with_binaries > "$dockerfile"
  fi
  docker build --network=host --file "$dockerfile" --tag "$tag" --build-arg "VERSION=$version" \
    --build-arg "REVISION=$(git rev-parse HEAD)" "$context" > "$folder/build.log" 2>&1 || { tail -n 40 "$folder/build.log" >&2; return 1; }
}
