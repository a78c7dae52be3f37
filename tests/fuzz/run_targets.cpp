// What a run reads that another machine may have written: plans, journals, parameters, labels; and pictures.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "io/image/color_image.h"
#include "io/image/png_reader.h"
#include "io/json/json_reader.h"
#include "io/json/json_tree.h"
#include "io/parameters_text.h"
#include "io/store/crc32c.h"
#include "io/store/journal.h"
#include "io/store/row_codec.h"
#include "io/store/run_array.h"
#include "io/store/run_plan.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/label_file.h"
#include "scratch_file.h"
#include "targets.h"

namespace meander::fuzz {

namespace {

// Whether `read` returned; false when it threw RunError(unusable) with a sentence.
bool is_usable(const std::function<void()>& read) {
  try {
    read();
    return true;
  } catch (const RunError& error) {
    demand(error.kind() == RunError::Kind::unusable, std::string("not stopped: ") + error.what());
    demand(std::string_view(error.what()).size() > 10, "an error is a sentence");
    return false;
  }
}

// The bytes with their checksum behind them: what a fuzzer does not find by itself.
std::string sealed(std::string_view bytes) {
  std::string text(bytes);
  const std::uint32_t checksum = crc32c(std::span<const char>(bytes.data(), bytes.size()));
  text.append(reinterpret_cast<const char*>(&checksum), sizeof checksum);
  return text;
}

// A record of a row with the payload, all its checksums right.
std::vector<std::byte> sealed_record(std::uint64_t row, Status status, std::span<const std::byte> payload) {
  std::vector<std::byte> record(store::record_header_bytes);
  record.insert(record.end(), payload.begin(), payload.end());
  const auto put = [&](std::size_t at, auto value) { std::memcpy(record.data() + at, &value, sizeof value); };
  put(0, std::uint32_t{0x31576E4D});
  put(4, static_cast<std::uint32_t>(status));
  put(8, row);
  put(16, std::uint64_t{payload.size()});
  put(24, crc32c(payload));
  put(28, crc32c(std::span<const std::byte>(record).first(28)));
  return record;
}

// Of a row of one of four stores: raw arrays or filtered chunks, compressed or not.
void run_record(std::uint8_t choice, std::span<const std::byte> payload) {
  StoreHeader header;
  header.samples = (choice & 1) != 0 ? 3 : 5000;
  header.compression = (choice & 2) != 0 ? Compression::standard : Compression::none;
  header.descriptors = {{"d2", 4, {}}};
  header.ids = {"a", "b"};
  header.labels = {0, 1};
  const EncodedRow encoded{1, sealed_record(1, Status::ok, payload)};
  demand(store::read_record_header(encoded.bytes).has_value(), "a sealed record has a header");
  try {
    const Row row = decode_row(header, encoded);
    if (row.report.status == Status::ok) {
      demand(row.samples.count() == header.samples, "an ok row has all its samples");
      demand(row.descriptors.size() == 1 && row.descriptors[0].values.size() == 4, "and its descriptors");
    }
  } catch (const ItemError& error) {
    demand(error.status() == Status::internal, std::string("a damaged record: ") + error.what());
  }
}

template <class Read>
bool is_right_usage(const Read& read) {
  try {
    read();
    return true;
  } catch (const UsageError& error) {
    demand(std::string_view(error.what()).size() > 10, "an error is a sentence");
    return false;
  }
}

constexpr std::uint64_t most_image_memory = std::uint64_t{64} << 20;

// All formats of images, whatever the bytes are: what differs are the seeds.
void run_color_image(std::string_view text) {
  const std::span<const std::byte> bytes = std::as_bytes(std::span(text.data(), text.size()));
  const ImageMemory memory = memory_of_image(bytes);
  if (memory.kept_bytes + memory.working_bytes > most_image_memory) return;  // as a small budget refuses it
  const ColorImage image = decode_color_image(bytes);
  if (image.problem.empty()) {
    demand(image.width > 0 && image.height > 0, "a picture has pixels");
    demand(image.rgb.size() == std::size_t{3} * image.width * image.height, "a color for each pixel");
    demand(image.rgb.size() == memory.kept_bytes, "memory is known before it is taken");
    demand(decode_color_image(bytes).rgb == image.rgb, "an image is the same when it is read again");
    return;
  }
  demand(image.is_lost() && image.rgb.empty(), "an image with a problem has no pixels");
  demand(image.problem.size() > 10, "a problem is a sentence");
  demand(image.loss == Note::image_unreadable || image.loss == Note::image_unsupported ||
             image.loss == Note::image_too_large,
         "a lost image says how it was lost");
}

}  // namespace

// plan.bin without its checksum.
void run_plan(std::string_view bytes) {
  scratch_file("plan.bin", sealed(bytes));
  RunPlan plan;
  if (!is_usable([&] { plan = store::read_plan(scratch_folder()); })) return;
  const StoreHeader& header = plan.header;
  demand(header.labels.size() == header.ids.size(), "every item has a label");
  demand(header.splits.empty() || header.splits.size() == header.ids.size(), "every item has a split");
  const StoreColumns& columns = *header.columns;
  demand(columns.chosen_count() <= most_chosen_columns, "there is a bit for every chosen column");
  for (const AttributeColumn& column : columns.attributes)
    demand(attribute_name_problem(column.name).empty(), "attributes have names");
  demand(header.compression <= Compression::none, "the compression is known");
  for (const Split split : header.splits)
    demand(static_cast<std::size_t>(split) < split_names.size(), "splits are known");
  demand(store::first_difference(plan, plan).empty(), "a plan does not differ from itself");
  store::require_same_plan(scratch_folder(), plan);
  const std::filesystem::path again = scratch_folder() / "again";
  std::filesystem::create_directory(again);
  store::write_plan(again, plan);
  store::require_same_plan(again, plan);
}

// array.json of a run of many machines.
void run_array(std::string_view bytes) {
  const std::filesystem::path store = scratch_folder() / "array.h5";
  std::filesystem::create_directories(array_folder(store));
  test::write_file(array_folder(store) / "array.json", bytes);
  std::optional<RunArray> array;
  if (!is_usable([&] { array = read_run_array(store); })) return;
  demand(array.has_value(), "what is there is read");
  demand(array->shards_per_task >= 1 && array->shards_per_task <= max_shards, "a task has shards");
  std::vector<std::pair<std::uint64_t, std::uint64_t>> parts;
  for (const ArrayShard& shard : array->shards) {
    demand(shard.begin <= shard.end && shard.end <= array->rows, "a shard has rows of the store");
    if (shard.rows() > 0) parts.emplace_back(shard.begin, shard.end);
  }
  std::sort(parts.begin(), parts.end());
  std::uint64_t next = 0;
  for (const auto& [begin, end] : parts) {
    demand(begin == next, "every row is of one shard");
    next = end;
  }
  demand(next == array->rows, "shards are all rows");
}

// A journal, the log of begun rows, and the payload of a record behind a byte that chooses the store.
void run_journal(std::string_view bytes) {
  const std::span<const std::byte> data = std::as_bytes(std::span(bytes.data(), bytes.size()));
  if (!data.empty()) run_record(std::to_integer<std::uint8_t>(data[0]), data.subspan(1));
  const std::filesystem::path path = scratch_file("rows-000000.wal", bytes);
  store::Journals journals(scratch_folder(), 1);
  std::uint64_t end = 0;
  journals.replay(0, 0, 1000, [&](const store::RecordHeader& header, std::uint64_t offset) {
    demand(header.row < 1000, "rows are those of the journal");
    demand(offset >= end, "records follow each other");
    end = offset + store::record_header_bytes + header.payload_bytes;
  });
  demand(std::filesystem::file_size(path) == end, "what is no record is cut off");
  const store::BegunLog log(scratch_file("begun.log", bytes));
  for (const std::uint64_t row : log.read(1000)) demand(row < 1000, "begun rows are those of the store");
}

void run_json(std::string_view bytes) {
  try {
    const JsonTree tree(bytes);
    demand(tree.memory_bytes() <= 4096 + JsonTree::most_bytes_per_character * 2 * bytes.size(),
           "the memory of a tree is bounded");
    std::vector<JsonValue> open{tree.root()};
    std::size_t values = 0;
    while (!open.empty()) {
      const JsonValue value = open.back();
      open.pop_back();
      ++values;
      demand(static_cast<bool>(value), "items are values");
      if (value.is_object() && !value.items().empty())
        demand(static_cast<bool>(value.member(value.items().front().name())), "members are found by name");
      if (const auto number = value.number()) demand(std::isfinite(*number), "numbers are finite");
      if (const auto count = value.count()) demand(*count <= std::uint64_t{1} << 53, "counts are exact");
      for (const JsonValue& item : value.items()) open.push_back(item);
    }
    demand(values <= bytes.size(), "a value is a character or more");
  } catch (const ItemError& error) {
    demand(error.status() == Status::unreadable, std::string("JSON: ") + error.what());
  }
  is_usable([&] {
    const JsonObject object(bytes, "the text");
    for (const auto& member : object.members()) {
      demand(!member.second.empty() && bytes.find(member.second) != std::string_view::npos,
             "values are as written");
      is_usable([&] { object.text(member.first); });
      is_usable([&] { object.integer(member.first); });
    }
    const std::string joined = join_members(split_members(bytes));
    demand(split_members(joined) == object.members(), "members are the same after joining");
    demand(parameter_differences(bytes, bytes).empty(), "parameters do not differ from themselves");
  });
  parameter_differences(bytes, R"({"seed":1})");
}

void run_png(std::string_view bytes) {
  try {
    const GrayImage image =
        decode_gray_png(std::as_bytes(std::span(bytes.data(), bytes.size())), std::uint64_t{16} << 20);
    demand(image.width > 0 && image.height > 0, "a picture has pixels");
    demand(image.values.size() == std::size_t{image.width} * image.height, "a value for each pixel");
    for (const float value : image.values) demand(value >= 0 && value <= 1, "values are in [0, 1]");
  } catch (const ItemError& error) {
    demand(error.status() == Status::unreadable, std::string("PNG: ") + error.what());
  }
}

void run_bmp(std::string_view bytes) { run_color_image(bytes); }

void run_gif(std::string_view bytes) { run_color_image(bytes); }

void run_tga(std::string_view bytes) { run_color_image(bytes); }

void run_webp(std::string_view bytes) { run_color_image(bytes); }

// As a .cla file, as a table or a list of labels, and as JSON with labels.
void run_labels(std::string_view bytes) {
  Classification classes;
  const std::filesystem::path path = scratch_file("labels", bytes);
  if (is_right_usage([&] { classes = read_classification(path); }))
    for (const Classification::Model& model : classes.models)
      demand(model.label < classes.classes.size() && !model.name.empty(), "a model has a class");
  LabelFile labels;
  if (is_right_usage([&] { labels = read_label_file(path.string()); }))
    for (const LabelLine& line : labels.lines)
      demand(line.line >= 1 && !line.names.empty(), "a label has a line and a name");
  const std::filesystem::path json = scratch_file("labels.json", bytes);
  if (is_right_usage([&] { labels = read_label_file(json.string()); }))
    for (const LabelLine& line : labels.lines)
      demand(line.line >= 1 && !line.names.empty(), "a label has an entry and a name");
}

}  // namespace meander::fuzz
