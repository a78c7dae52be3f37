# cmake -DROOT=... -DWORK=... -DGENERATOR=... -P links.cmake: meander_check_apart accepts libraries that are apart, and
# names the way from a product to the laboratory through other libraries, aliases and generator expressions.
file(REMOVE_RECURSE ${WORK})
foreach(way none direct interface alias private link_only)
  execute_process(
    COMMAND ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/linked -B ${WORK}/${way} -G ${GENERATOR}
            -DROOT=${ROOT} -DWAY=${way}
    RESULT_VARIABLE result OUTPUT_VARIABLE out ERROR_VARIABLE out)
  if(way STREQUAL "none")
    if(NOT result EQUAL 0)
      message(FATAL_ERROR "libraries that are apart are refused:\n${out}")
    endif()
  elseif(result EQUAL 0 OR NOT out MATCHES "the product links the laboratory: product -> .*pictures")
    message(FATAL_ERROR "the link `${way}` is not refused:\n${out}")
  endif()
endforeach()
