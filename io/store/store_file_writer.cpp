#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "io/store/chunk_codec.h"
#include "io/store/file_checksum.h"
#include "io/store/store_file.h"

namespace meander::store {

namespace fs = std::filesystem;

namespace {

// What is written before the system is asked to bring it to the disk, so that seal() need not wait for all of
// it.
constexpr std::uint64_t bytes_at_once = std::uint64_t{2} << 20;

Hdf5Properties file_creation() {
  Hdf5Properties creation(H5Pcreate(H5P_FILE_CREATE), "make file properties");
  const hid_t id = creation.get();
  hdf5_check(H5Pset_userblock(id, user_block_bytes), "set the user block");
  hdf5_check(H5Pset_obj_track_times(id, false), "leave out times");
  // The root group lists its members in its header; dense storage starts at 8 otherwise.
  hdf5_check(H5Pset_link_phase_change(id, 64, 32), "set the storage of links");
  hdf5_check(H5Pset_attr_phase_change(id, 64, 32), "set the storage of attributes");
  return creation;
}

Hdf5Properties file_access(const StoreLayout& layout) {
  // Chunk index nodes of a large store are grouped in blocks of 1 MiB rather than scattered between the
  // chunks.
  constexpr std::uint64_t large = std::uint64_t{64} << 20;
  constexpr std::uint64_t bytes_per_sample = 56;
  Hdf5Properties access = access_without_locks();
  const hid_t id = access.get();
  hdf5_check(H5Pset_libver_bounds(id, H5F_LIBVER_V18, H5F_LIBVER_V110), "set the format version");
  if (layout.rows * layout.samples * bytes_per_sample > large)
    hdf5_check(H5Pset_meta_block_size(id, hsize_t{1} << 20), "set the metadata block");
  return access;
}

Hdf5Group make_group(const Hdf5File& file, const char* name) {
  const Hdf5Properties creation(H5Pcreate(H5P_GROUP_CREATE), "make group properties");
  hdf5_check(H5Pset_obj_track_times(creation.get(), false), "leave out times");
  hdf5_check(H5Pset_link_phase_change(creation.get(), 64, 32), "set the storage of links");
  hdf5_check(H5Pset_link_creation_order(creation.get(), H5P_CRT_ORDER_TRACKED), "keep the order of links");
  return Hdf5Group(H5Gcreate2(file.get(), name, H5P_DEFAULT, creation.get(), H5P_DEFAULT),
                   std::string("create group ") + name);
}

void write_root_attributes(hid_t file, const StoreLayout& layout, const StoreHeader& header) {
  const Hdf5Group root(H5Gopen2(file, "/", H5P_DEFAULT), "open the root group");
  write_attribute(root.get(), "format", "meander");
  write_attribute(root.get(), "format_version", store_format_version);
  write_attribute(root.get(), "method_version", header.method_version);
  write_attribute(root.get(), "tool_version",
                  header.tool_version.empty() ? tool_version() : header.tool_version);
  write_attribute(root.get(), "content", content_name(*header.columns));
  if (header.columns->are_chosen()) write_attribute(root.get(), "columns", column_list(header.columns));
  write_attribute(root.get(), "seed", header.seed);
  write_attribute(root.get(), "samples", layout.samples);
  for (std::size_t s = 0; s < point_set_names.size(); ++s)
    if (header.columns->counts[s] > 0)
      write_attribute(root.get(), std::string(point_set_names[s]).c_str(), header.columns->counts[s]);
  write_attribute(root.get(), "rows", layout.rows);
  write_attribute(root.get(), "parameters", header.parameters_json);
  write_attribute(root.get(), "compression",
                  header.compression == Compression::standard ? "standard" : "none");
}

void write_dataset_attributes(hid_t dataset, const DatasetSpec& spec, const StoreHeader& header) {
  if (spec.role == Role::descriptor) {
    for (const DescriptorSchema& descriptor : header.descriptors)
      if (spec.path == descriptor_dataset(descriptor).path)
        for (const auto& [name, text] : descriptor.attributes) write_attribute(dataset, name.c_str(), text);
    return;
  }
  write_attribute(dataset, "description", spec.doc);
  if (!spec.unit.empty()) write_attribute(dataset, "unit", spec.unit);
  if (spec.path == "/points") write_attribute(dataset, "order", header.order);
  if (spec.column != nullptr && spec.column->values == Values::groups)
    write_attribute(dataset, "names", header.columns->query_groups);
  if (spec.role == Role::label) write_attribute(dataset, "names", header.label_names);
  if (spec.path == "/items/lacks" || spec.path == "/items/missing") {
    std::vector<std::string> names;
    for (std::size_t bit = 0; bit < header.columns->chosen_count(); ++bit)
      names.push_back(header.columns->chosen_name(bit));
    write_attribute(dataset, "names", names);
  }
  if (!spec.value_names.empty())
    write_attribute(dataset, "names",
                    std::vector<std::string>(spec.value_names.begin(), spec.value_names.end()));
}

}  // namespace

std::string tool_version() { return MEANDER_VERSION; }

std::string user_block_text(std::uint64_t file_bytes, std::uint32_t checksum) {
  std::string text = fmt::format("meander store\nbytes {}\ncrc32c {:08x}\n", file_bytes, checksum);
  text.resize(user_block_bytes, '\0');
  return text;
}

namespace {

// Refuses a disk without room for the file while there is nothing yet that the library could not close.
void require_space(const fs::path& path, std::uint64_t bytes) {
  open_file(path, O_WRONLY | O_CREAT | O_TRUNC);
  try {
    reserve_space(path, bytes);
  } catch (...) {
    ::unlink(path.c_str());
    throw;
  }
}

}  // namespace

StoreFileWriter::StoreFileWriter(const fs::path& path, const StoreLayout& layout, const StoreHeader& header,
                                 std::uint64_t reserve)
    : path_(path), layout_(layout) {
  begin(header, {}, reserve);
}

StoreFileWriter::StoreFileWriter(const fs::path& path, const StoreLayout& layout, const StoreHeader& header,
                                 std::span<const StorePack> packs)
    : path_(path), layout_(layout) {
  constexpr std::uint64_t bytes_per_mapping = 256;
  begin(header, packs, (packs.size() + 1) * layout.datasets.size() * bytes_per_mapping);
}

void StoreFileWriter::begin(const StoreHeader& header, std::span<const StorePack> packs,
                            std::uint64_t reserve) {
  require_space(path_, reserve);
  const Hdf5Lock lock;
  try {
    file_ =
        Hdf5File(H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, file_creation().get(), file_access(layout_).get()),
                 "create " + path_.string());
    reserve_space(path_, reserve);
    written_ = open_file(path_, O_RDWR);
    create(header, packs);
  } catch (const Hdf5Error& error) {
    abandon();
    throw RunError(RunError::Kind::stopped, error.what());
  } catch (...) {
    abandon();
    throw;
  }
}

void StoreFileWriter::create(const StoreHeader& header, std::span<const StorePack> packs) {
  write_root_attributes(file_.get(), layout_, header);
  const Hdf5Group descriptors = make_group(file_, "/descriptors");
  const auto group_of = [&](const std::string& name) {
    const bool wanted = std::any_of(header.descriptors.begin(), header.descriptors.end(),
                                    [&](const DescriptorSchema& d) { return d.group == name; });
    return wanted ? make_group(file_, ("/" + name).c_str()) : Hdf5Group();
  };
  const Hdf5Group anisotropy = group_of("anisotropy"), certificate = group_of("certificate");
  const StoreColumns& columns = *header.columns;
  const Hdf5Group tensor =
      columns.has(&Samples::tensor_direction) ? make_group(file_, "/tensor") : Hdf5Group();
  const Hdf5Group sharp = columns.has(&Samples::sharp_points) ? make_group(file_, "/sharp") : Hdf5Group();
  const Hdf5Group queries = columns.has(&Samples::query_points) ? make_group(file_, "/queries") : Hdf5Group();
  const Hdf5Group attributes = columns.attributes.empty() ? Hdf5Group() : make_group(file_, "/attributes");
  const Hdf5Group items = make_group(file_, "/items");
  for (const DatasetLayout& dataset : layout_.datasets) {
    const Hdf5Type type = make_type(dataset);
    const std::vector<hsize_t> extents = make_extents(dataset, layout_);
    const Hdf5Space space(H5Screate_simple(static_cast<int>(extents.size()), extents.data(), nullptr),
                          "make the space of " + dataset.spec.path);
    const Hdf5Properties creation = packs.empty() ? make_creation(dataset, layout_.compression)
                                                  : make_virtual_creation(dataset, layout_, packs);
    datasets_.emplace_back(H5Dcreate2(file_.get(), dataset.spec.path.c_str(), type.get(), space.get(),
                                      H5P_DEFAULT, creation.get(), H5P_DEFAULT),
                           "create " + dataset.spec.path);
    write_dataset_attributes(datasets_.back().get(), dataset.spec, header);
    if (!dataset.spec.link.empty())
      hdf5_check(H5Lcreate_hard(file_.get(), dataset.spec.path.c_str(), file_.get(),
                                dataset.spec.link.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                 "link " + dataset.spec.link);
  }
  if (columns.has_names()) create_names(packs);
  if (!packs.empty()) write_packs(file_.get(), packs);
}

void StoreFileWriter::create_names(std::span<const StorePack> packs) {
  hsize_t bytes = 0;
  for (const StorePack& pack : packs) bytes += pack.names_bytes;
  // How long they are is known when the last row is written; of an index at once.
  const hsize_t no_limit = H5S_UNLIMITED;
  const Hdf5Space space(H5Screate_simple(1, &bytes, bytes == 0 ? &no_limit : nullptr),
                        std::string("make the space of ") + names_path);
  const Hdf5Properties creation =
      bytes == 0 ? make_names_creation(layout_.compression) : make_virtual_names(packs);
  names_dataset_ = Hdf5Dataset(H5Dcreate2(file_.get(), names_path, H5T_STD_U8LE, space.get(), H5P_DEFAULT,
                                          creation.get(), H5P_DEFAULT),
                               std::string("create ") + names_path);
  write_attribute(names_dataset_.get(), "description", names_doc);
  write_attribute(names_dataset_.get(), "unit", "1");
}

void StoreFileWriter::append_names(std::span<const std::byte> names) {
  while (!names.empty()) {
    const std::size_t count = std::min(names.size(), names_chunk - names_.size());
    names_.insert(names_.end(), names.begin(), names.begin() + static_cast<std::ptrdiff_t>(count));
    names = names.subspan(count);
    if (names_.size() == names_chunk) write_names_chunk();
  }
}

void StoreFileWriter::write_names_chunk() {
  const Hdf5Lock lock;
  const hsize_t begin = names_begin_, end = begin + names_.size();
  names_.resize(names_chunk);
  std::vector<std::byte> filtered;
  append_filtered(names_, 1, layout_.compression, filtered);
  names_.clear();
  names_begin_ = end;
  try {
    hdf5_check(H5Dset_extent(names_dataset_.get(), &end), std::string("lengthen ") + names_path);
    hdf5_check(H5Dwrite_chunk(names_dataset_.get(), H5P_DEFAULT, 0, &begin, filtered.size(), filtered.data()),
               fmt::format("write {} of {}", names_path, path_.string()));
  } catch (const Hdf5Error& error) {
    throw RunError(RunError::Kind::stopped, error.what());
  }
}

StoreFileWriter::~StoreFileWriter() {
  const Hdf5Lock lock;
  if (!sealed_) abandon();
}

void StoreFileWriter::abandon() {
  // On a full disk the library cannot write what its cache holds and could then not close the file, ever. An
  // emptied file has room again.
  if (file_ && ::truncate(path_.c_str(), 0) != 0) path_.clear();
  datasets_.clear();
  names_dataset_.close();
  file_.close();
  if (!path_.empty()) ::unlink(path_.c_str());
}

void StoreFileWriter::write_chunk(std::size_t dataset, std::uint64_t row, std::uint32_t part,
                                  std::span<const std::byte> filtered) {
  const Hdf5Lock lock;
  const DatasetLayout& layout = layout_.datasets[dataset];
  if (H5Dwrite_chunk(datasets_[dataset].get(), H5P_DEFAULT, 0, chunk_offset(layout, row, part).data(),
                     filtered.size(), filtered.data()) >= 0) {
    written_bytes_ += filtered.size();
    if (written_bytes_ < bytes_at_once) return;
    begin_sync(written_);
    written_bytes_ = 0;
    return;
  }
  try {
    throw_hdf5_error(fmt::format("write {} row {} of {}", layout.spec.path, row, path_.string()));
  } catch (const Hdf5Error& error) {
    throw RunError(RunError::Kind::stopped, error.what());
  }
}

void StoreFileWriter::seal() {
  const Hdf5Lock lock;
  if (!names_.empty()) write_names_chunk();
  try {
    if (!names_dataset_.close()) throw_hdf5_error("close a dataset of " + path_.string());
    for (Hdf5Dataset& dataset : datasets_)
      if (!dataset.close()) throw_hdf5_error("close a dataset of " + path_.string());
    datasets_.clear();
    // Flushing first: when it fails, the file is still open and can be emptied and closed.
    hdf5_check(H5Fflush(file_.get(), H5F_SCOPE_LOCAL), "write " + path_.string());
    if (!file_.close()) throw_hdf5_error("close " + path_.string());
  } catch (const Hdf5Error& error) {
    throw RunError(RunError::Kind::stopped, error.what());
  }
  release_reserved(written_, path_);
  begin_sync(written_);
  const std::uint64_t bytes = file_size(written_, path_);
  const std::string block = user_block_text(bytes, checksum_of_file(written_, user_block_bytes, path_));
  write_at(written_, std::as_bytes(std::span(block)), 0, path_);
  sync_file(written_, path_);
  sealed_ = true;
}

}  // namespace meander::store
