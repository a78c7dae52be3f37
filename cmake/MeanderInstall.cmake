# install + export: find_package(meander) gives meander::kernels, meander::io and meander::pipeline.
include(CMakePackageConfigHelpers)
# With the laboratory also meander::laboratory_kernels and meander::laboratory_io.
set(installed_libraries meander_kernels meander_io meander_pipeline)
set(installed_headers PATTERN "*.h")
if(MEANDER_LABORATORY)
  list(APPEND installed_libraries meander_laboratory_kernels meander_laboratory_io)
else()
  foreach(folder kernels/analyse kernels/pointset kernels/render io/plot)
    list(APPEND installed_headers PATTERN "${folder}" EXCLUDE)
  endforeach()
endif()
install(TARGETS ${installed_libraries} EXPORT meanderTargets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS meander RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(EXPORT meanderTargets NAMESPACE meander:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/meander)
install(DIRECTORY kernels io pipeline DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/meander
        FILES_MATCHING ${installed_headers})
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/meanderConfig.cmake.in
  ${PROJECT_BINARY_DIR}/meanderConfig.cmake INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/meander)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/meanderConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/meanderConfig.cmake ${PROJECT_BINARY_DIR}/meanderConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/meander)
