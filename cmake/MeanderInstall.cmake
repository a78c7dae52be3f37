# install + export: find_package(meander) gives meander::kernels, and <meander/sampler.h> with the headers beside it.
#
# Public are the headers directly below <meander/>. Those below <meander/kernels/> are what they include: they hold the
# parameters of single kernels and may change. Everything else is internal and not installed; tests/consumer builds
# against an installation, so a header that is missing from the list fails there.
include(CMakePackageConfigHelpers)
set(public_headers sampler.h sample_parameters.h row.h)
set(included_headers
  core/cancel.h core/instruction_set.h core/random.h core/status.h core/vector3.h core/work_budget.h
  curve/curve_key.h curve/curve_tree.h
  cut/cut_to_disk.h
  density/density.h
  describe/depth_views.h describe/describe_samples.h describe/distance_histogram.h describe/oriented_pairs.h describe/shape_dna.h
  describe/shape_moments.h
  describe/shell_harmonics.h
  flatten/flatten_chart.h
  locate/chart_places.h locate/elements.h locate/embree_locator.h
  mesh/box_frame.h mesh/coarsen_mesh.h mesh/measured_mesh.h mesh/polygon_mesh.h mesh/prepared_mesh.h
  model/sample_parameters.h model/sampler.h
  sample/place_samples.h sample/samples.h sample/spaced_samples.h
  segment/random_walk.h segment/segment_mesh.h
  tensor/chart_alignment.h tensor/make_tensor_field.h tensor/tangent_tensor.h tensor/tensor_field.h)
list(TRANSFORM public_headers PREPEND kernels/public/)
install(TARGETS meander_kernels EXPORT meanderTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS meander RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(EXPORT meanderTargets NAMESPACE meander:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/meander)
install(FILES ${public_headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/meander)
foreach(header ${included_headers})
  cmake_path(GET header PARENT_PATH folder)
  install(FILES kernels/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/meander/kernels/${folder})
endforeach()
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/meanderConfig.cmake.in
  ${PROJECT_BINARY_DIR}/meanderConfig.cmake INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/meander)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/meanderConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/meanderConfig.cmake ${PROJECT_BINARY_DIR}/meanderConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/meander)
