# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# Gives our scripts the libraries of arm64, and compiles against them. Source it after deploy/common.sh.

# Runs on the unpacked packages of a sysroot: writes dpkg's database of them, which says to what package a file belongs and what
# versions of it a program needs. dpkg itself would run the packages' scripts, and those are programs of the other architecture.
# shellcheck disable=SC2016 # sh expands this, not we
readonly arm64_dpkg_database='
set -e
info="$1/var/lib/dpkg/info"
for deb in "$1"/var/cache/apt/archives/*.deb; do
  name=$(dpkg-deb --field "$deb" Package)
  if [ "$(dpkg-deb --field "$deb" Multi-Arch)" = same ]; then name="$name:arm64"; fi
  dpkg-deb --fsys-tarfile "$deb" | tar --list --file - | sed "s|^\.||; s|/$||; s|^$|/.|" > "$info/$name.list"
  for table in shlibs symbols; do
    dpkg-deb --info "$deb" "$table" > "$info/$name.$table" 2> /dev/null || rm "$info/$name.$table"
  done
  dpkg-deb --field "$deb" | sed "/^Package:/a Status: install ok installed" >> "$1/var/lib/dpkg/status"
  echo >> "$1/var/lib/dpkg/status"
done'

# arm64_sysroot: makes a Debian arm64 in the cache folder, once, and sets `sysroot`. Its packages are unpacked only. None of their
# scripts run, so neither qemu nor binfmt_misc is needed for that.
arm64_sysroot() {
  local packages
  packages=$(deploy/install-packages --list sysroot service | paste -sd,)
  sysroot="${cache_dir:?}/sysroot-arm64-$(sha256sum <<< "$packages $arm64_dpkg_database" | cut -c-12)"
  if [ -d "$sysroot" ]; then return; fi
  rm -rf "$sysroot.new"
  mmdebstrap --arch=arm64 --variant=extract --quiet --include="$packages" --extract-hook="$arm64_dpkg_database" bookworm "$sysroot.new"
  # Of this version of the database, files are named by package and architecture.
  echo 1 > "$sysroot.new/var/lib/dpkg/info/format"
  # Links to /lib/.. would lead to this machine's libraries.
  local link
  find "$sysroot.new" -type l -lname '/*' | while read -r link; do
    ln --symbolic --force --no-dereference --relative "$sysroot.new$(readlink "$link")" "$link"
  done
  # This is what the script of ca-certificates does.
  (LC_ALL=C; cat "$sysroot.new"/usr/share/ca-certificates/mozilla/*.crt) > "$sysroot.new/etc/ssl/certs/ca-certificates.crt"
  mv "$sysroot.new" "$sysroot"
}

# arm64_configure FOLDER OPTION..: a build folder of programs for arm64.
arm64_configure() {
  cmake -G Ninja -B "$1" -DCMAKE_BUILD_TYPE=Release --log-level=WARNING -DSEGSERVE_BUILD_PCL=OFF -DSEGSERVE_BUILD_BENCHMARKS=OFF \
    -DCMAKE_TOOLCHAIN_FILE="$PWD/deploy/cmake/aarch64-linux-gnu.cmake" -DSEGSERVE_SYSROOT="${sysroot:?}" "${@:2}"
}
