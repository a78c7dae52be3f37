#include "jobs/export/export_arrays.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>

#include "io/file/atomic_file.h"
#include "io/json_writer.h"
#include "io/run_error.h"
#include "io/table/npy_header.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/units.h"
#include "jobs/cli/usage_error.h"
#include "kernels/core/spelling.h"
#include "kernels/sample/point_frames.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

const std::vector<std::string> array_names = {"points",     "normals", "rgb",         "points_rgb",
                                              "face_index", "corners", "barycentric", "uv",
                                              "curve_rank", "density", "texcoord"};
constexpr std::string_view attribute_word = "attribute:";

// Names of arrays, where a list is the names and `attribute:NAME`.
std::string array_problem(const std::string& name) {
  if (name.starts_with(attribute_word)) return {};
  if (std::find(array_names.begin(), array_names.end(), name) != array_names.end()) return {};
  const std::string near = nearest(name, array_names);
  return fmt::format("--arrays: `{}` is none of {}, attribute:NAME{}", name, fmt::join(array_names, ", "),
                     near.empty() ? "" : fmt::format("; did you mean `{}`?", near));
}

// The column of a store that an array of this name is made of, of those that may be left out.
std::optional<SampleColumn> column_of_array(std::string_view name) {
  if (name == "face_index") name = name_of(SampleColumn::face);
  const auto at = std::find(sample_column_names.begin(), sample_column_names.end(), name);
  if (at == sample_column_names.end()) return std::nullopt;
  return static_cast<SampleColumn>(at - sample_column_names.begin());
}

// The place among the attributes of a store; none where it has no such.
std::optional<std::size_t> attribute_of_array(const StoreColumns& columns, std::string_view name) {
  for (std::size_t i = 0; i < columns.attributes.size(); ++i)
    if (columns.attributes[i].name == name.substr(attribute_word.size())) return i;
  return std::nullopt;
}

// Of the files: `attribute:NAME` becomes `attribute_NAME`, since some systems know no colon in file names.
std::string file_word(std::string name) {
  if (name.starts_with(attribute_word)) name[attribute_word.size() - 1] = '_';
  return name;
}

template <class Number>
std::string npy_file(std::string_view type, std::span<const Number> values, std::uint64_t columns) {
  std::vector<std::uint64_t> shape = {values.size() / columns};
  if (columns > 1) shape.push_back(columns);
  std::string file = npy_header(type, shape);
  file.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  return file;
}

// The array with coordinates in the frame, of their type: float32 as stored, float64 of the file.
template <class Make>
std::string in_frame(PointFrame frame, const Row& row, const Make& make) {
  if (frame == PointFrame::stored) return make("<f4", std::span<const float>(row.samples.points));
  return make("<f8", std::span<const double>(file_points(row.report, row.samples.points)));
}

// Coordinates, then red, green and blue from 0 to 1.
template <class Number>
std::vector<Number> points_and_colors(std::span<const Number> points, std::span<const std::uint8_t> rgb) {
  std::vector<Number> values;
  values.reserve(2 * points.size());
  for (std::size_t i = 0; i < points.size(); i += 3) {
    for (std::size_t k = 0; k < 3; ++k) values.push_back(points[i + k]);
    for (std::size_t k = 0; k < 3; ++k) values.push_back(static_cast<Number>(rgb[i + k]) / 255);
  }
  return values;
}

std::string npy_of(const std::string& name, const StoreColumns& columns, PointFrame frame, const Row& row) {
  const Samples& samples = row.samples;
  const auto floats = [](const std::vector<float>& values, std::uint64_t width) {
    return npy_file("<f4", std::span<const float>(values), width);
  };
  const auto numbers = [](const std::vector<std::uint32_t>& values, std::uint64_t width) {
    return npy_file("<u4", std::span<const std::uint32_t>(values), width);
  };
  if (name == "points")
    return in_frame(frame, row, [](std::string_view type, auto points) { return npy_file(type, points, 3); });
  if (name == "normals") return floats(samples.normals, 3);
  if (name == "rgb") return npy_file("|u1", std::span<const std::uint8_t>(samples.rgb), 3);
  if (name == "points_rgb")
    return in_frame(frame, row, [&]<class Number>(std::string_view type, std::span<const Number> points) {
      const std::vector<Number> values = points_and_colors(points, std::span(samples.rgb));
      return npy_file(type, std::span<const Number>(values), 6);
    });
  if (name == "face_index") return numbers(samples.face, 1);
  if (name == "corners") return numbers(samples.corners, 3);
  if (name == "barycentric") return floats(samples.barycentric, 2);
  if (name == "uv") return floats(samples.uv, 2);
  if (name == "curve_rank") return numbers(samples.curve_rank, 1);
  if (name == "texcoord") return floats(samples.texcoord, 2);
  if (name.starts_with(attribute_word)) {
    const std::size_t i = *attribute_of_array(columns, name);
    if (columns.attributes[i].is_classes())
      return npy_file("<i4", std::span<const std::int32_t>(samples.classes[i]), columns.attributes[i].width);
    return floats(samples.attributes[i], columns.attributes[i].width);
  }
  return floats(samples.density, 1);
}

// A text as an array of numpy without dimensions.
std::string npy_text(std::string_view ascii) {
  std::string file = npy_header(fmt::format("<U{}", ascii.size()), {});
  for (const char c : ascii) {  // UTF-32
    file += c;
    file.append(3, '\0');
  }
  return file;
}

std::string json_of(const StoreReader& store, std::uint64_t number, PointFrame frame, const Row& row) {
  const ItemReport& report = row.report;
  JsonWriter json;
  json.begin_object();
  json.member("id", store.id(number));
  json.member("row", number);
  if (const std::int32_t label = store.label(number); label >= 0)
    json.member("class", store.label_names()[static_cast<std::size_t>(label)]);
  if (store.split(number) != Split::none) json.member("split", name_of(store.split(number)));
  json.member("area", report.area);
  const auto list = [&json](std::string_view name, std::span<const double> values) {
    json.key(name);
    json.begin_array();
    for (const double value : values) json.value(value);
    json.end_array();
  };
  list("bbox", report.bbox);
  json.member("frame", name_of(frame));
  list("loc", report.loc);
  json.member("scale", report.scale);
  json.end_object();
  return json.text() + "\n";
}

// STEM-000000.tar, with -train, -test or -val in front of the number.
std::string shard_name(const std::string& stem, Split split, std::uint64_t shard) {
  const char* const part = split == Split::train        ? "-train"
                           : split == Split::test       ? "-test"
                           : split == Split::validation ? "-val"
                                                        : "";
  return fmt::format("{}{}-{:06}.tar", stem, part, shard);
}

// The shards of one split.
class ShardFiles {
 public:
  ShardFiles(fs::path folder, std::string stem, Split split, std::uint64_t most_bytes)
      : folder_(std::move(folder)), stem_(std::move(stem)), split_(split), most_bytes_(most_bytes) {}

  void add(const std::vector<std::pair<std::string, std::string>>& members) {
    std::uint64_t bytes = 0;
    for (const auto& [name, content] : members) bytes += TarWriter::member_bytes(content.size());
    if (file_ && bytes_ + bytes + end_bytes > most_bytes_) finish();
    if (!file_) {
      names_.push_back(shard_name(stem_, split_, names_.size()));
      file_ = std::make_unique<AtomicFile>(folder_ / names_.back(), FullDisk::stops_run);
      bytes_ = 0;
    }
    TarWriter tar([this](std::string_view piece) { file_->append(piece); });
    for (const auto& [name, content] : members) tar.add(name, {content});
    bytes_ += bytes;
  }
  void finish() {
    if (!file_) return;
    TarWriter([this](std::string_view piece) { file_->append(piece); }).finish();
    file_->commit();
    file_.reset();
  }
  const std::vector<std::string>& names() const { return names_; }

 private:
  static constexpr std::uint64_t end_bytes = 1024;

  fs::path folder_;
  std::string stem_;
  Split split_;
  std::uint64_t most_bytes_, bytes_ = 0;
  std::vector<std::string> names_;
  std::unique_ptr<AtomicFile> file_;
};

}  // namespace

bool is_array_format(const std::string& format) { return format == "npz" || format == "webdataset"; }

void add_array_export_options(const Command& whole, ArrayExport& options) {
  Command command = whole.under("Arrays");
  command
      .add_option(
          "--arrays", options.arrays,
          fmt::format("npz, webdataset: arrays, separated by commas (default: points,normals and, of "
                      "a store with colours, rgb): {}, attribute:NAME; points_rgb: N x 6, the colours "
                      "from 0 to 1",
                      fmt::join(array_names, ", ")))
      .separator(',');
  command
      .add_option("--shard-bytes", options.shard_bytes,
                  "webdataset: size that a shard does not exceed, unless a single model does")
      .show_default()
      .on_given([&options] { options.shapes_shards = true; });
}

void check_array_export(const ArrayExport& options, const std::string& format) {
  if (!options.arrays.empty() && !is_array_format(format))
    throw UsageError("--arrays applies to --format npz and webdataset only");
  for (const std::string& name : options.arrays)
    if (const std::string problem = array_problem(name); !problem.empty()) throw UsageError(problem);
  if (options.shapes_shards && format != "webdataset")
    throw UsageError("--shard-bytes applies to --format webdataset only");
  parse_bytes(options.shard_bytes);
}

std::vector<std::string> chosen_arrays(const StoreReader& store, const ArrayExport& options) {
  const StoreColumns& columns = store.columns();
  const bool colors = columns.colors, surfaces = columns.rows == RowKind::surfaces;
  std::vector<std::string> chosen;
  for (const std::string& name : options.arrays) {
    if (!colors && (name == "rgb" || name == "points_rgb"))
      throw UsageError("--arrays: the store has no `" + name + "`: it was made without --colors");
    if (surfaces && (name == "face_index" || name == "corners" || name == "barycentric"))
      throw UsageError("--arrays: the store has no `" + name + "`: its models are parametric surfaces");
    if (!columns.texcoord && name == "texcoord")
      throw UsageError("--arrays: the store has no `texcoord`: it was made without --texcoord");
    if (name.starts_with(attribute_word) && !attribute_of_array(columns, name))
      throw UsageError(
          fmt::format("--arrays: the store has no attribute `{0}`: it was made without "
                      "`--attribute {0}`",
                      name.substr(attribute_word.size())));
    if (!surfaces && name == "uv") throw UsageError("--arrays: the store has no `uv`: its models are meshes");
    if (const auto column = column_of_array(name)) store.require(*column, fmt::format("--arrays {}", name));
    if (std::find(chosen.begin(), chosen.end(), name) == chosen.end()) chosen.push_back(name);
  }
  if (!chosen.empty()) return chosen;
  chosen = {"points"};
  if (columns.has(SampleColumn::normals)) chosen.emplace_back("normals");
  if (colors) chosen.emplace_back("rgb");
  return chosen;
}

void write_npz(const PutBytes& put, const StoreColumns& columns, const std::vector<std::string>& arrays,
               PointFrame frame, const Row& row, const std::string& id) {
  try {
    StoredZipWriter zip(put);
    for (const std::string& name : arrays)
      zip.add(file_word(name) + ".npy", {npy_of(name, columns, frame, row)});
    zip.add("frame.npy", {npy_text(name_of(frame))});
    zip.add("loc.npy", {npy_file("<f8", std::span<const double>(row.report.loc), 1)});
    const std::string_view scale(reinterpret_cast<const char*>(&row.report.scale), sizeof(double));
    zip.add("scale.npy", {npy_header("<f8", {}), scale});
    zip.finish();
  } catch (const std::length_error&) {
    throw RunError(RunError::Kind::unusable, "the arrays of `" + id +
                                                 "` exceed the 4 GiB that an .npz file holds: choose fewer "
                                                 "with --arrays, or --format webdataset");
  }
}

bool is_webdataset_file(std::string_view name, const std::string& stem) {
  if (!name.starts_with(stem) || !name.ends_with(".tar")) return false;
  name.remove_prefix(stem.size());
  name.remove_suffix(4);
  for (const std::string_view part : {"-train", "-test", "-val"})
    if (name.starts_with(part)) name.remove_prefix(part.size());
  return name.size() >= 7 && name[0] == '-' && name.find_first_not_of("0123456789", 1) == name.npos;
}

std::vector<fs::path> webdataset_files(const WebdatasetExport& wanted) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator at(wanted.folder, error), end; !error && at != end; at.increment(error))
    if (is_webdataset_file(at->path().filename().string(), wanted.stem)) files.push_back(at->path());
  std::sort(files.begin(), files.end());
  return files;
}

bool export_webdataset(const StoreReader& store, const std::vector<std::uint64_t>& rows,
                       const WebdatasetExport& wanted, const std::atomic<bool>& stop) {
  const std::vector<fs::path> earlier = webdataset_files(wanted);
  std::map<Split, ShardFiles> files;
  std::uint64_t unlabelled = 0;
  for (const std::uint64_t number : rows) {
    if (stop) return false;
    const Row row = store.read_row(number);
    const std::string key = fmt::format("{:08}", number);
    std::vector<std::pair<std::string, std::string>> members;
    for (const std::string& name : wanted.arrays)
      members.emplace_back(fmt::format("{}.{}.npy", key, file_word(name)),
                           npy_of(name, store.columns(), wanted.frame, row));
    if (const std::int32_t label = store.label(number); label >= 0)
      members.emplace_back(key + ".cls", std::to_string(label));
    else
      ++unlabelled;
    members.emplace_back(key + ".json", json_of(store, number, wanted.frame, row));
    const Split split = store.split(number);
    files.try_emplace(split, wanted.folder, wanted.stem, split, wanted.most_bytes).first->second.add(members);
  }
  std::vector<std::string> written;
  for (auto& [split, shards] : files) {
    shards.finish();
    written.insert(written.end(), shards.names().begin(), shards.names().end());
  }
  // Loaders take every shard that they find.
  std::error_code error;
  for (const fs::path& file : earlier)
    if (std::find(written.begin(), written.end(), file.filename().string()) == written.end())
      fs::remove(file, error);
  fmt::print("{} models in {} shards in {}\n", rows.size(), written.size(), wanted.folder.string());
  if (unlabelled > 0) fmt::print("{} models without a class have no .cls\n", unlabelled);
  return true;
}

}  // namespace meander
