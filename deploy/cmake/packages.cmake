# SPDX-License-Identifier: Apache-2.0
# Debian packages by CPack, see deploy/make-packages. They hold what no other installation does: the service of systemd with its
# settings and its user, manual pages, completion.
set(folder ${PROJECT_SOURCE_DIR}/deploy)

install(FILES ${folder}/systemd/segserve.service DESTINATION lib/systemd/system COMPONENT server)
install(FILES ${folder}/systemd/segserve.toml DESTINATION /etc/segserve COMPONENT server)
install(DIRECTORY ${PROJECT_BINARY_DIR}/man/server/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT server)
install(DIRECTORY ${PROJECT_BINARY_DIR}/man/segctl/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT segctl)
install(FILES ${folder}/debian/completion DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME segserve
        COMPONENT server)
install(FILES ${folder}/debian/completion DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME segctl
        COMPONENT segctl)
foreach(package IN ITEMS server:segserve segctl:segctl dev:libsegserve-dev)
  string(REGEX MATCH "^(.*):(.*)$" _ ${package})
  install(FILES ${folder}/debian/copyright ${PROJECT_BINARY_DIR}/changelog.gz
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${CMAKE_MATCH_2} COMPONENT ${CMAKE_MATCH_1})
endforeach()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL server segctl dev)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "segmentation of colored 3D point clouds as a service")
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "The segserve maintainers <maintainers@segserve.example.org>")
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)

set(CPACK_DEBIAN_SERVER_PACKAGE_NAME segserve)
set(CPACK_DEBIAN_SERVER_PACKAGE_SECTION net)
set(CPACK_COMPONENT_SERVER_DESCRIPTION "The server: robots and back ends send compressed colored clouds over gRPC,
and get a label per point and the merge tree of the scene.")
set(CPACK_DEBIAN_SERVER_PACKAGE_DEPENDS adduser)
set(CPACK_DEBIAN_SERVER_PACKAGE_CONTROL_EXTRA
    "${folder}/debian/segserve/conffiles;${folder}/debian/segserve/postinst;${folder}/debian/segserve/prerm;${folder}/debian/segserve/postrm")

set(CPACK_DEBIAN_SEGCTL_PACKAGE_NAME segctl)
set(CPACK_DEBIAN_SEGCTL_PACKAGE_SECTION science)
set(CPACK_COMPONENT_SEGCTL_DESCRIPTION "The command line client: segments clouds with or without a server, cuts
saved merge trees, scores results, and measures a server under load.")

set(CPACK_DEBIAN_DEV_PACKAGE_NAME libsegserve-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_COMPONENT_DEV_DESCRIPTION "The C++ libraries, for segmentation in process and through a server: static
libraries, headers, the proto files, and CMake's find_package(segserve).")
# The libraries are static, so that their users link what they need; find_package(segserve) looks for all of it.
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)
execute_process(COMMAND ${folder}/install-packages --list core service OUTPUT_VARIABLE dev_packages COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^\n]+-dev" dev_packages "${dev_packages}")
list(JOIN dev_packages ", " CPACK_DEBIAN_DEV_PACKAGE_DEPENDS)
include(CPack)
