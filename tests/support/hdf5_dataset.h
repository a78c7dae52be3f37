// Datasets in HDF5 files, written by the C library alone. For tests that link it.
#pragma once

#include <hdf5.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace meander::test {

// Adds a dataset of that path (groups on the way are made) to a file, which is created where there is none.
// Without values it is chunked and has its fill value everywhere, whatever its extents.
inline void add_hdf5_dataset(const std::filesystem::path& path, const std::string& name,
                             const std::vector<hsize_t>& extents, const std::vector<double>& values,
                             hid_t type = H5T_IEEE_F64LE) {
  const bool there = std::filesystem::exists(path);
  const hid_t file = there ? H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT)
                           : H5Fcreate(path.c_str(), H5F_ACC_EXCL, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t links = H5Pcreate(H5P_LINK_CREATE), creation = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_create_intermediate_group(links, 1);
  std::vector<hsize_t> chunk;
  for (const hsize_t extent : extents) chunk.push_back(std::clamp<hsize_t>(extent, 1, 4));
  if (values.empty()) H5Pset_chunk(creation, static_cast<int>(chunk.size()), chunk.data());
  const hid_t space = H5Screate_simple(static_cast<int>(extents.size()), extents.data(), nullptr);
  const hid_t dataset = H5Dcreate2(file, name.c_str(), type, space, links, creation, H5P_DEFAULT);
  const bool written = values.empty() || H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT,
                                                  values.data()) >= 0;
  const bool made = dataset >= 0;
  if (made) H5Dclose(dataset);
  H5Sclose(space);
  H5Pclose(creation);
  H5Pclose(links);
  if (H5Fclose(file) < 0 || !made || !written) throw std::runtime_error("cannot write " + path.string());
}

}  // namespace meander::test
