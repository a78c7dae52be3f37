# install + export: find_package(meander) gives meander::kernels and the headers of kernels/public as <meander/...>, which
# include each other and the standard library alone (tests/product/interface.cmake).
include(CMakePackageConfigHelpers)
install(TARGETS meander_kernels EXPORT meanderTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS meander RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(EXPORT meanderTargets NAMESPACE meander:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/meander)
install(DIRECTORY kernels/public/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/meander FILES_MATCHING PATTERN "*.h")
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/meanderConfig.cmake.in
  ${PROJECT_BINARY_DIR}/meanderConfig.cmake INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/meander)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/meanderConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/meanderConfig.cmake ${PROJECT_BINARY_DIR}/meanderConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/meander)

# Manual pages and completions are made with the program by itself, from its options. A program with sanitizers is not
# one to be installed.
if(NOT MEANDER_SANITIZE)
  set(pages ${PROJECT_BINARY_DIR}/share)
  add_custom_command(OUTPUT ${PROJECT_BINARY_DIR}/pages.stamp
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${pages}
    COMMAND meander pages ${pages}
    COMMAND ${CMAKE_COMMAND} -E touch ${PROJECT_BINARY_DIR}/pages.stamp
    DEPENDS meander COMMENT "Writing manual pages and completions" VERBATIM)
  add_custom_target(meander_pages ALL DEPENDS ${PROJECT_BINARY_DIR}/pages.stamp)
  install(DIRECTORY ${pages}/ DESTINATION ${CMAKE_INSTALL_DATADIR})
endif()

if(TARGET meander_python)
  install(TARGETS meander_python LIBRARY DESTINATION ${MEANDER_PYTHON_DIR}/meander)
  get_property(files GLOBAL PROPERTY MEANDER_PYTHON_FILES)
  install(FILES ${files} DESTINATION ${MEANDER_PYTHON_DIR}/meander)
  get_property(files GLOBAL PROPERTY MEANDER_FIGURES_FILES)
  install(FILES ${files} DESTINATION ${MEANDER_PYTHON_DIR}/meander/figures)
endif()

# Component `libraries` (only when it is asked for, as the tarball does): the shared libraries of the program and of the
# Python package but for those of the C library, in lib/meander, where both look first. DT_RPATH, not DT_RUNPATH: it holds for what these
# libraries load too.
set(bundle lib/meander)
set(bundled $<TARGET_FILE:meander>)
set(package "")
file(RELATIVE_PATH up /${CMAKE_INSTALL_BINDIR} /${bundle})
set_target_properties(meander PROPERTIES INSTALL_RPATH "$ORIGIN/${up}")
target_link_options(meander PRIVATE -Wl,--disable-new-dtags)
if(TARGET meander_python)
  file(RELATIVE_PATH up /${MEANDER_PYTHON_DIR}/meander /${bundle})
  set_target_properties(meander_python PROPERTIES INSTALL_RPATH "$ORIGIN/${up}")
  target_link_options(meander_python PRIVATE -Wl,--disable-new-dtags)
  set(package $<TARGET_FILE:meander_python>)
endif()
install(CODE "
  file(GET_RUNTIME_DEPENDENCIES EXECUTABLES \"${bundled}\" LIBRARIES ${package}
    RESOLVED_DEPENDENCIES_VAR found UNRESOLVED_DEPENDENCIES_VAR missing
    PRE_EXCLUDE_REGEXES [[^ld-linux]] [[^lib(c|m|dl|rt|pthread|resolv|util)\\.so]])
  if(missing)
    message(FATAL_ERROR \"libraries that were not found: \${missing}\")
  endif()
  foreach(library IN LISTS found)
    file(INSTALL \${library} DESTINATION \"\${CMAKE_INSTALL_PREFIX}/${bundle}\" TYPE SHARED_LIBRARY
         FOLLOW_SYMLINK_CHAIN)
  endforeach()" COMPONENT libraries EXCLUDE_FROM_ALL)
