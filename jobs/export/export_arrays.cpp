#include "jobs/export/export_arrays.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
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
#include "jobs/export/export_format.h"
#include "kernels/core/joined_texts.h"
#include "kernels/core/spelling.h"
#include "kernels/sample/point_frames.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view colored_points = "points_rgb";

// The names of arrays, apart from `attribute:NAME`.
std::vector<std::string> array_names() {
  std::vector<std::string> names;
  for (const SampleColumn& column : sample_columns) names.push_back(column.array_name());
  names.emplace_back(colored_points);
  return names;
}
constexpr std::string_view attribute_word = "attribute:";

// Names of arrays, where a list is the names and `attribute:NAME`.
std::string array_problem(const std::string& name) {
  if (name.starts_with(attribute_word)) return {};
  const std::vector<std::string> names = array_names();
  if (std::find(names.begin(), names.end(), name) != names.end()) return {};
  const std::string near = nearest(name, names);
  return fmt::format("--arrays: `{}` is none of {}, attribute:NAME{}", name, joined_texts(names),
                     near.empty() ? "" : fmt::format("; did you mean `{}`?", near));
}

// The column that an array of this name, none of those of attributes, is made of.
std::size_t column_of_array(std::string_view name) {
  if (name == colored_points) return column_of(&Samples::rgb);
  std::size_t c = 0;
  while (sample_columns.at(c).array_name() != name) ++c;
  return c;
}

// The place among the attributes of a store; none where it has no such.
std::optional<std::size_t> attribute_of_array(const StoreColumns& columns, std::string_view name) {
  for (std::size_t i = 0; i < columns.attributes.size(); ++i)
    if (columns.attributes[i].name == name.substr(attribute_word.size())) return i;
  return std::nullopt;
}

// The name in files: `attribute:NAME` becomes `attribute_NAME`, since some systems know no colon in file
// names.
std::string file_word(std::string name) {
  if (name.starts_with(attribute_word)) name[attribute_word.size() - 1] = '_';
  return name;
}

template <class Value>
std::string npy_file(std::span<const Value> values, std::uint64_t columns) {
  std::vector<std::uint64_t> shape = {values.size() / columns};
  if (columns > 1) shape.push_back(columns);
  std::string file = npy_header(numpy_type<Value>, shape);
  file.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  return file;
}
template <class Value>
std::string npy_file(const std::vector<Value>& values, std::uint64_t columns) {
  return npy_file(std::span<const Value>(values), columns);
}

// The array with coordinates in the frame, of their type: float32 as stored, float64 of the file.
template <class Make>
std::string in_frame(PointFrame frame, const Row& row, std::span<const float> points, const Make& make) {
  if (frame == PointFrame::stored) return make(points);
  return make(std::span<const double>(file_points(row.report, points)));
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
  if (name.starts_with(attribute_word)) {
    const std::size_t i = *attribute_of_array(columns, name);
    const std::uint32_t width = columns.attributes[i].width;
    return columns.attributes[i].is_classes() ? npy_file(samples.classes[i], width)
                                              : npy_file(samples.attributes[i], width);
  }
  if (name == colored_points)
    return in_frame(frame, row, samples.points, [&]<class Number>(std::span<const Number> points) {
      return npy_file(points_and_colors(points, std::span(samples.rgb)), 6);
    });
  const SampleColumn& column = sample_columns[column_of_array(name)];
  const bool is_length = column.unit == "length / scale" && column.width != 2;
  if (is_length && column.width == 0 && frame == PointFrame::file) {
    std::vector<double> lengths;
    for (const float value : samples.*std::get<std::vector<float> Samples::*>(column.array))
      lengths.push_back(row.report.scale * double{value});
    return npy_file(lengths, 1);
  }
  if (is_length && column.width == 3)
    return in_frame(frame, row, samples.*std::get<std::vector<float> Samples::*>(column.array),
                    [](auto points) { return npy_file(points, 3); });
  return with_array(column, samples,
                    [&](const auto& values) { return npy_file(values, column.values_each()); });
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

// Coordinates of the model's file are loc + scale * those of the frame.
struct ShardFrame {
  std::string_view name;
  std::array<double, 3> loc;
  double scale;
};

ShardFrame shard_frame(const WebdatasetExport& wanted, const ItemReport& report) {
  if (!wanted.schema) return {name_of(wanted.frame), report.loc, report.scale};
  const SchemaPlace place = schema_place(report, wanted.schema->kind);
  return {text_of(schema_words, wanted.schema->kind),
          {place.center.x, place.center.y, place.center.z},
          place.size};
}

std::string sample_json(const StoreReader& store, std::uint64_t number, const ShardFrame& frame,
                        const ItemReport& report) {
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
  json.member("frame", frame.name);
  list("loc", frame.loc);
  json.member("scale", frame.scale);
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

// Names behind the key of a model, and contents.
using Members = std::vector<std::pair<std::string, std::string>>;

Members array_members(const StoreReader& store, const WebdatasetExport& wanted, const Row& row,
                      const std::string& id) {
  Members members;
  if (!wanted.schema) {
    for (const std::string& name : wanted.arrays)
      members.emplace_back(file_word(name) + ".npy", npy_of(name, store.columns(), wanted.frame, row));
    return members;
  }
  const std::vector<std::string> names = schema_members(wanted.schema->kind);
  for (std::size_t number = 0; number < names.size(); ++number) {
    std::string& content = members.emplace_back(names[number], "").second;
    write_schema_file([&content](std::string_view bytes) { content += bytes; }, store.columns(),
                      *wanted.schema, number, row, id);
  }
  return members;
}

// The shards of one split.
class ShardFiles {
 public:
  ShardFiles(fs::path folder, std::string stem, Split split, std::uint64_t most_bytes)
      : folder_(std::move(folder)), stem_(std::move(stem)), split_(split), most_bytes_(most_bytes) {}

  void add(const std::string& key, const Members& members) {
    std::uint64_t bytes = 0;
    for (const auto& [name, content] : members) bytes += TarWriter::member_bytes(content.size());
    if (file_ && bytes_ + bytes + end_bytes > most_bytes_) finish();
    if (!file_) {
      names_.push_back(shard_name(stem_, split_, names_.size()));
      file_ = std::make_unique<AtomicFile>(folder_ / names_.back(), FullDisk::stops_run);
      bytes_ = 0;
    }
    TarWriter tar([this](std::string_view piece) { file_->append(piece); });
    for (const auto& [name, content] : members) tar.add(key + "." + name, {content});
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

void add_array_export_options(const Command& whole, ArrayExport& options) {
  Command command = whole.under("Arrays");
  command
      .add_option("--arrays", options.arrays,
                  fmt::format("{}: arrays, separated by commas (default: points,normals and, of "
                              "a store with colors, rgb): {}, attribute:NAME; points_rgb: N x 6, the colors "
                              "from 0 to 1",
                              formats_with(ExportContent::arrays), joined_texts(array_names())))
      .separator(',');
  command
      .add_option("--shard-bytes", options.shard_bytes,
                  "webdataset: size that a shard does not exceed, unless a single model does")
      .show_default()
      .bytes()
      .on_given([&options] { options.shapes_shards = true; });
  command
      .add_option(
          "--schema", options.schema,
          "npz, webdataset: files with the keys, shapes and types that the loaders of a published project "
          "read, of a store with --queries (docs/TRAINING.md)")
      .one_of(all_words(schema_words));
  command
      .add_option("--uncertain", options.uncertain,
                  "--schema: points whose side is not certain, and models without any other: drop, or keep")
      .show_default()
      .one_of(all_words(uncertain_words))
      .on_given([&options] { options.chooses_uncertain = true; });
}

void check_array_export(const ArrayExport& options, const std::string& format) {
  if (!options.arrays.empty() && export_format(format).content != ExportContent::arrays)
    throw UsageError("--arrays applies to --format " + formats_with(ExportContent::arrays, "and") + " only");
  if (!options.schema.empty() && export_format(format).content != ExportContent::arrays)
    throw UsageError("--schema applies to --format " + formats_with(ExportContent::arrays, "and") + " only");
  if (!options.schema.empty() && !options.arrays.empty())
    throw UsageError("--schema says which arrays there are: leave --arrays out");
  if (options.chooses_uncertain && options.schema.empty())
    throw UsageError("--uncertain applies to --schema only");
  for (const std::string& name : options.arrays)
    if (const std::string problem = array_problem(name); !problem.empty()) throw UsageError(problem);
  if (options.shapes_shards && format != "webdataset")
    throw UsageError("--shard-bytes applies to --format webdataset only");
}

std::vector<std::string> chosen_arrays(const StoreReader& store, const ArrayExport& options) {
  const StoreColumns& columns = store.columns();
  std::vector<std::string> chosen;
  for (const std::string& name : options.arrays) {
    if (!name.starts_with(attribute_word))
      store.require(column_of_array(name), fmt::format("--arrays {}", name));
    else if (!attribute_of_array(columns, name))
      throw UsageError(
          fmt::format("--arrays: the store has no attribute `{0}`: it was made without "
                      "`--attribute {0}`",
                      name.substr(attribute_word.size())));
    if (std::find(chosen.begin(), chosen.end(), name) == chosen.end()) chosen.push_back(name);
  }
  if (!chosen.empty()) return chosen;
  chosen = {"points"};
  if (columns.has(&Samples::normals)) chosen.emplace_back("normals");
  if (columns.has(&Samples::rgb)) chosen.emplace_back("rgb");
  return chosen;
}

void write_npz(const PutBytes& put, const StoreColumns& columns, const std::vector<std::string>& arrays,
               PointFrame frame, const Row& row, const std::string& id) {
  try {
    StoredZipWriter zip(put);
    for (const std::string& name : arrays)
      zip.add(file_word(name) + ".npy", {npy_of(name, columns, frame, row)});
    zip.add("frame.npy", {npy_text(name_of(frame))});
    zip.add("loc.npy", {npy_file(std::span<const double>(row.report.loc), 1)});
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
  std::uint64_t unlabeled = 0;
  for (const std::uint64_t number : rows) {
    if (stop) return false;
    const Row row = store.read_row(number);
    Members members = array_members(store, wanted, row, store.id(number));
    if (const std::int32_t label = store.label(number); label >= 0)
      members.emplace_back("cls", std::to_string(label));
    else
      ++unlabeled;
    members.emplace_back("json", sample_json(store, number, shard_frame(wanted, row.report), row.report));
    const Split split = store.split(number);
    files.try_emplace(split, wanted.folder, wanted.stem, split, wanted.most_bytes)
        .first->second.add(fmt::format("{:08}", number), members);
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
  if (unlabeled > 0) fmt::print("{} models without a class have no .cls\n", unlabeled);
  return true;
}

}  // namespace meander
