# SPDX-License-Identifier: Apache-2.0
# Says what `cmake --install` puts where, so that find_package(segserve) works. Each component of that package has an export set.
# The components of the installation become Debian packages: server is segserve, segctl is segctl, dev is libsegserve-dev.
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME dev)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/segserve)

install(TARGETS segserve_core segserve_codec EXPORT segserveCoreTargets)
install(DIRECTORY core/include/segserve DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.hpp")
install(EXPORT segserveCoreTargets NAMESPACE segserve:: DESTINATION ${package_dir})

if(SEGSERVE_BUILD_PCL)
  install(TARGETS segserve_pcl EXPORT segservePclTargets)
  install(DIRECTORY core/pcl_adapter/include/segserve DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.hpp")
  install(EXPORT segservePclTargets NAMESPACE segserve:: DESTINATION ${package_dir})
endif()

if(SEGSERVE_BUILD_SERVICE)
  install(TARGETS segserve COMPONENT server)
  install(TARGETS segctl COMPONENT segctl)
  if(TARGET segctl_lccp)
    install(TARGETS segctl_lccp LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/segserve COMPONENT segctl)
  endif()
  install(TARGETS segserve_proto segserve_wire segserve_health segserve_recording segserve_tls segserve_client EXPORT segserveClientTargets)
  install(DIRECTORY client/include/segserve proto/include/segserve DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.hpp")
  install(DIRECTORY ${PROJECT_BINARY_DIR}/proto/generated/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
          FILES_MATCHING PATTERN "*.pb.h")
  install(DIRECTORY proto/segserve proto/google DESTINATION ${CMAKE_INSTALL_DATADIR}/segserve/proto
          FILES_MATCHING PATTERN "*.proto")
  install(EXPORT segserveClientTargets NAMESPACE segserve:: DESTINATION ${package_dir})
  if(SEGSERVE_BUILD_PCL)
    install(TARGETS segserve_pcl_client EXPORT segservePclClientTargets)
    install(DIRECTORY client/pcl/include/segserve DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.hpp")
    install(EXPORT segservePclClientTargets NAMESPACE segserve:: DESTINATION ${package_dir})
  endif()
endif()

configure_package_config_file(deploy/cmake/segserveConfig.cmake.in ${PROJECT_BINARY_DIR}/segserveConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/segserveConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/segserveConfig.cmake ${PROJECT_BINARY_DIR}/segserveConfigVersion.cmake
        DESTINATION ${package_dir})
install(FILES LICENSE README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
