# Read by cpack once for every generator: only the tarball has the libraries.
if(CPACK_GENERATOR STREQUAL "TGZ")
  list(GET CPACK_INSTALL_CMAKE_PROJECTS 0 build)
  set(CPACK_INSTALL_CMAKE_PROJECTS "${build};meander;ALL;/;${build};meander;libraries;/")
endif()
