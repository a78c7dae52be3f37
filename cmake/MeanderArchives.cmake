# meander_hdf5 and meander_draco: programs are linked with the archives of these libraries where the system has them, for
# they start sooner. The shared library of HDF5 brings libcurl and what that needs, 27 libraries that no
# run calls, and Draco's is mostly relocations. Modules of Python, which need position-independent code, and systems
# without the archives take the shared libraries.
include(CheckCXXSourceCompiles)

set(program $<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>)

add_library(meander_hdf5 INTERFACE)
target_include_directories(meander_hdf5 SYSTEM INTERFACE ${HDF5_INCLUDE_DIRS})
# The functions of version 1.10 by their names there; 1.12 and later have others under the same names.
target_compile_definitions(meander_hdf5 INTERFACE H5_USE_110_API)
# Only beside the headers: that of another installation may be another version.
find_library(MEANDER_HDF5_ARCHIVE libhdf5.a PATHS ${HDF5_LIBRARY_DIRS} ${HDF5_LIBDIR} NO_DEFAULT_PATH)
find_library(MEANDER_SZIP_LIBRARY sz)
mark_as_advanced(MEANDER_HDF5_ARCHIVE MEANDER_SZIP_LIBRARY)
if(MEANDER_HDF5_ARCHIVE AND MEANDER_SZIP_LIBRARY)
  add_library(meander_hdf5_archive STATIC IMPORTED GLOBAL)
  set_target_properties(meander_hdf5_archive PROPERTIES IMPORTED_LOCATION ${MEANDER_HDF5_ARCHIVE})
  target_link_libraries(meander_hdf5_archive INTERFACE ${MEANDER_SZIP_LIBRARY} ZLIB::ZLIB ${CMAKE_DL_LIBS} m)
  set(CMAKE_REQUIRED_INCLUDES ${HDF5_INCLUDE_DIRS})
  set(CMAKE_REQUIRED_LIBRARIES meander_hdf5_archive)
  check_cxx_source_compiles("#include <hdf5.h>
    int main() { return H5open() < 0 || H5Fcreate(\"\", H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT) < 0; }"
    MEANDER_HDF5_ARCHIVE_LINKS)
  unset(CMAKE_REQUIRED_INCLUDES)
  unset(CMAKE_REQUIRED_LIBRARIES)
endif()
if(MEANDER_HDF5_ARCHIVE_LINKS)
  target_link_libraries(meander_hdf5 INTERFACE $<IF:${program},meander_hdf5_archive,PkgConfig::HDF5>)
else()
  target_link_libraries(meander_hdf5 INTERFACE PkgConfig::HDF5)
endif()

add_library(meander_draco INTERFACE)
target_include_directories(meander_draco SYSTEM
  INTERFACE $<TARGET_PROPERTY:draco::draco,INTERFACE_INCLUDE_DIRECTORIES>)
if(TARGET draco::draco_static)
  target_link_libraries(meander_draco INTERFACE $<IF:${program},draco::draco_static,draco::draco>)
else()
  target_link_libraries(meander_draco INTERFACE draco::draco)
endif()
unset(program)
