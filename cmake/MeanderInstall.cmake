# install + export: find_package(meander) gives meander::kernels, meander::io and meander::pipeline.
include(CMakePackageConfigHelpers)
install(TARGETS meander_kernels meander_io meander_pipeline EXPORT meanderTargets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS meander RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(EXPORT meanderTargets NAMESPACE meander:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/meander)
install(DIRECTORY kernels io pipeline DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/meander
        FILES_MATCHING PATTERN "*.h")
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/meanderConfig.cmake.in
  ${PROJECT_BINARY_DIR}/meanderConfig.cmake INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/meander)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/meanderConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/meanderConfig.cmake ${PROJECT_BINARY_DIR}/meanderConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/meander)
