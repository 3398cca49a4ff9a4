# SPDX-License-Identifier: Apache-2.0
# Cross-compiles for arm64 with Debian's compiler against a Debian sysroot, and runs the programs under qemu. deploy/arm64.sh makes
# the sysroot and names it by -DSEGSERVE_SYSROOT=FOLDER.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES SEGSERVE_SYSROOT)

set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)

set(CMAKE_SYSROOT ${SEGSERVE_SYSROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)

set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static -L ${SEGSERVE_SYSROOT})

set(ENV{PKG_CONFIG_SYSROOT_DIR} ${SEGSERVE_SYSROOT})
set(ENV{PKG_CONFIG_LIBDIR} ${SEGSERVE_SYSROOT}/usr/lib/aarch64-linux-gnu/pkgconfig:${SEGSERVE_SYSROOT}/usr/share/pkgconfig)
