# meander_hdf5, meander_draco and meander_cairo: the archives of these libraries where the system has them, for programs
# start sooner with them, and need less of a system. The shared library of HDF5 brings libcurl and what that needs, 27
# libraries that no run calls, Draco's is mostly relocations, and cairo's brings those of X11 and of the font formats, of
# which hardly anything is called. The archive of HDF5 is not for shared libraries: libmeander.so links because it calls
# nothing of it.
include(CheckCXXSourceCompiles)

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
  target_link_libraries(meander_hdf5 INTERFACE meander_hdf5_archive)
else()
  target_link_libraries(meander_hdf5 INTERFACE PkgConfig::HDF5)
endif()

add_library(meander_draco INTERFACE)
target_include_directories(meander_draco SYSTEM
  INTERFACE $<TARGET_PROPERTY:draco::draco,INTERFACE_INCLUDE_DIRECTORIES>)
if(TARGET draco::draco_static)
  target_link_libraries(meander_draco INTERFACE draco::draco_static)
else()
  target_link_libraries(meander_draco INTERFACE draco::draco)
endif()

if(MEANDER_LABORATORY)
  add_library(meander_cairo INTERFACE)
  target_include_directories(meander_cairo SYSTEM INTERFACE ${CAIRO_INCLUDE_DIRS})
  set(archives "")
  foreach(name cairo fontconfig freetype pixman-1 expat brotlidec brotlicommon)
    find_library(MEANDER_${name}_ARCHIVE lib${name}.a)
    mark_as_advanced(MEANDER_${name}_ARCHIVE)
    list(APPEND archives ${MEANDER_${name}_ARCHIVE})
  endforeach()
  list(APPEND archives PNG::PNG ZLIB::ZLIB Threads::Threads m)
  if(NOT archives MATCHES "NOTFOUND")
    set(CMAKE_REQUIRED_INCLUDES ${CAIRO_INCLUDE_DIRS})
    set(CMAKE_REQUIRED_LIBRARIES ${archives})
    check_cxx_source_compiles("#include <cairo.h>
      int main() {
        cairo_t* context = cairo_create(cairo_image_surface_create(CAIRO_FORMAT_A8, 1, 1));
        cairo_select_font_face(context, \"sans-serif\", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
        cairo_show_text(context, \"text\");
        return cairo_status(context);
      }" MEANDER_CAIRO_ARCHIVE_LINKS)
    unset(CMAKE_REQUIRED_INCLUDES)
    unset(CMAKE_REQUIRED_LIBRARIES)
  endif()
  # Not with sanitizers: what fontconfig keeps to the end would be reported as ours.
  if(MEANDER_CAIRO_ARCHIVE_LINKS AND NOT MEANDER_SANITIZE)
    target_link_libraries(meander_cairo INTERFACE ${archives})
  else()
    target_link_libraries(meander_cairo INTERFACE PkgConfig::CAIRO)
  endif()
  unset(archives)
endif()
