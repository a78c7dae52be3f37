# cpack -G DEB|TGZ in the build folder (docs/INSTALL.md): a Debian package, and a tarball with its libraries that runs
# from any folder.
set(CPACK_PACKAGE_NAME meander)
set(CPACK_PACKAGE_CONTACT "The Meander developers")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGE_DESCRIPTION "Turns folders of mesh files into one HDF5 store of evenly spread samples and descriptors.
 The program meander with manual pages and completions, the Python package of the same name, and the
 library and headers for C++.")
set(CPACK_GENERATOR DEB TGZ)
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGE_FILE_NAME meander-${PROJECT_VERSION}-linux-${CMAKE_SYSTEM_PROCESSOR})
set(CPACK_PROJECT_CONFIG_FILE ${PROJECT_SOURCE_DIR}/cmake/MeanderCPack.cmake)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "fonts-dejavu-core, python3 (>= 3.9), python3-numpy")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS
    "bash-completion, man-db, python3-h5py, python3-matplotlib, libeigen3-dev, libembree-dev, libtbb-dev")
include(CPack)
