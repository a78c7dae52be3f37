#include "io/store/row_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "io/store/chunk_codec.h"
#include "io/store/crc32c.h"
#include "io/store/schema.h"
#include "io/utf8.h"

namespace meander {

namespace store {

namespace {

constexpr std::uint32_t record_magic = 0x31576E4Du;  // "MnW1"

template <class T>
T load(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

template <class T>
void append(std::vector<std::byte>& out, T value) {
  const auto bytes = std::as_bytes(std::span(&value, 1));
  out.insert(out.end(), bytes.begin(), bytes.end());
}

// Takes bytes from the front of a payload. Running out of them is a bug, unless it has not been checked.
class Cursor {
 public:
  explicit Cursor(std::span<const std::byte> bytes) : bytes_(bytes) {}
  std::span<const std::byte> take(std::size_t count) {
    if (count > bytes_.size())
      throw ItemError(Status::internal,
                      fmt::format("a journal record ends {} bytes too early", count - bytes_.size()));
    const auto taken = bytes_.first(count);
    bytes_ = bytes_.subspan(count);
    return taken;
  }
  std::uint32_t take_length() { return load<std::uint32_t>(take(4).data()); }
  bool at_end() const { return bytes_.empty(); }

 private:
  std::span<const std::byte> bytes_;
};

RecordParts take_head(const StoreHeader& header, Cursor& cursor) {
  RecordParts parts;
  parts.items = cursor.take(item_record(header.columns).bytes);
  parts.status = static_cast<Status>(parts.items[item_record(header.columns).status_offset]);
  const auto reason = cursor.take(cursor.take_length());
  parts.reason = {reinterpret_cast<const char*>(reason.data()), reason.size()};
  if (parts.status == Status::ok)
    for (const DescriptorSchema& descriptor : header.descriptors)
      parts.descriptors.push_back(cursor.take(descriptor.width * sizeof(float)));
  return parts;
}

// The chunk of these samples of a dataset, after its length.
void append_chunk(const DatasetSpec& spec, const ChunkShape& chunk, std::span<const std::byte> values,
                  Compression compression, std::vector<std::byte>& out) {
  const std::size_t length_at = out.size();
  append<std::uint32_t>(out, 0);
  if (values.size() == chunk.samples * value_bytes(spec)) {
    append_filtered(values, element_size(spec.type), compression, out);
  } else {  // the last one, whose tail is filled
    std::vector<std::byte> bytes(values.begin(), values.end());
    bytes.resize(chunk.samples * value_bytes(spec));
    write_fill(spec, std::span(bytes).subspan(values.size()));
    append_filtered(bytes, element_size(spec.type), compression, out);
  }
  const auto length = static_cast<std::uint32_t>(out.size() - length_at - 4);
  std::memcpy(out.data() + length_at, &length, 4);
}

// Points of a row in a dataset.
std::size_t points_of(const StoreHeader& header, const DatasetSpec& spec) {
  return header.columns->points_of(spec.set, header.samples);
}

// Calls visit(spec, chunk, part) for all chunks of the samples of a row in the order of records: the first
// one of every dataset, then the second ones, and so on.
template <class Visit>
void for_each_chunk(const StoreHeader& header, const Visit& visit) {
  const std::uint64_t rows = header.ids.size();
  std::array<ChunkShape, point_set_names.size()> chunks;
  for (std::size_t s = 0; s < chunks.size(); ++s)
    chunks[s] = set_chunk(header.columns, rows, header.samples, static_cast<PointSet>(s));
  const std::uint32_t parts = most_chunks_per_row(header.columns, rows, header.samples);
  for (std::uint32_t part = 0; part < parts; ++part)
    for (const DatasetSpec& spec : datasets_of(header.columns)) {
      const ChunkShape& chunk = chunks[static_cast<std::size_t>(spec.set)];
      if (spec.role == Role::samples && part < chunk.chunks_per_row) visit(spec, chunk, part);
    }
}

// spent: the same samples, whose arrays are freed as soon as they are encoded; may be null.
void append_samples(const StoreHeader& header, const Samples& samples, Samples* spent,
                    std::vector<std::byte>& out) {
  std::vector<std::byte> scratch;
  for_each_chunk(header, [&](const DatasetSpec& spec, const ChunkShape& chunk, std::uint32_t part) {
    const std::size_t each = std::max<std::size_t>(spec.width, 1), all = points_of(header, spec) * each;
    if (chunk.rows > 1) {
      const auto row = spec.stored(samples, 0, all, scratch);
      out.insert(out.end(), row.begin(), row.end());
    } else {
      const std::size_t begin = part * chunk.samples * each,
                        end = std::min(all, begin + chunk.samples * each);
      append_chunk(spec, chunk, spec.stored(samples, begin, end, scratch), header.compression, out);
    }
    if (spent != nullptr && part + 1 == chunk.chunks_per_row) spec.free(*spent);
  });
}

void append_descriptors(const StoreHeader& header, const Row& row, std::vector<std::byte>& out) {
  for (const DescriptorSchema& schema : header.descriptors) {
    const auto found = std::find_if(row.descriptors.begin(), row.descriptors.end(),
                                    [&](const DescriptorRow& d) { return d.name == schema.name; });
    const auto bytes = std::as_bytes(std::span(found->values));
    out.insert(out.end(), bytes.begin(), bytes.end());
  }
}

// Whether all arrays are of that many samples; those of other sets, where there are samples, of all points.
void check_samples(const StoreHeader& header, const Samples& samples, Status status, std::size_t count) {
  for (const DatasetSpec& spec : datasets_of(header.columns)) {
    if (spec.role != Role::samples) continue;
    const std::size_t expected =
        spec.set == PointSet::samples || count == 0 ? count : points_of(header, spec);
    const std::size_t bytes = spec.count(samples) * element_size(spec.type);
    if (bytes != expected * value_bytes(spec))
      throw ItemError(Status::internal,
                      fmt::format("{} of a row with status {} has {} bytes instead of {}", spec.path,
                                  name_of(status), bytes, expected * value_bytes(spec)));
  }
}

void check_descriptors(const StoreHeader& header, const Row& row) {
  const std::size_t expected = row.report.status == Status::ok ? header.descriptors.size() : 0;
  if (row.descriptors.size() != expected)
    throw ItemError(Status::internal,
                    fmt::format("a row with status {} has {} descriptors instead of {}",
                                name_of(row.report.status), row.descriptors.size(), expected));
  for (const DescriptorRow& descriptor : row.descriptors) {
    const auto schema = std::find_if(header.descriptors.begin(), header.descriptors.end(),
                                     [&](const DescriptorSchema& s) { return s.name == descriptor.name; });
    if (schema == header.descriptors.end())
      throw ItemError(Status::internal, fmt::format("the store has no descriptor {}", descriptor.name));
    if (schema->width != descriptor.values.size())
      throw ItemError(Status::internal,
                      fmt::format("descriptor {} has {} values instead of {}", descriptor.name,
                                  descriptor.values.size(), schema->width));
  }
  // With equal numbers of names, all known, one missing means one twice.
  for (std::size_t i = 0; i < row.descriptors.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (row.descriptors[i].name == row.descriptors[j].name)
        throw ItemError(Status::internal,
                        fmt::format("descriptor {} is there twice", row.descriptors[i].name));
}

// Writes the record header, which the checksum of the payload is a part of, to the front.
void write_record_header(const RecordHeader& facts, std::span<std::byte> record) {
  std::byte* at = record.data();
  const std::uint32_t status = static_cast<std::uint32_t>(facts.status);
  std::memcpy(at, &record_magic, 4);
  std::memcpy(at + 4, &status, 4);
  std::memcpy(at + 8, &facts.row, 8);
  std::memcpy(at + 16, &facts.payload_bytes, 8);
  std::memcpy(at + 24, &facts.payload_crc32c, 4);
  const std::uint32_t header_crc = crc32c(std::span<const std::byte>(record).first(28));
  std::memcpy(at + 28, &header_crc, 4);
}

Samples decode_samples(const StoreHeader& header, const RecordParts& parts) {
  Samples samples;
  std::size_t next = 0;
  for_each_chunk(header, [&](const DatasetSpec& spec, const ChunkShape& chunk, std::uint32_t part) {
    const std::size_t each = std::max<std::size_t>(spec.width, 1), all = points_of(header, spec) * each;
    if (chunk.rows > 1) return spec.put(parts.samples[next++], 0, all, samples);
    std::vector<std::byte> bytes(chunk.samples * value_bytes(spec));
    if (!unfilter(parts.samples[next++], element_size(spec.type), header.compression, bytes))
      throw ItemError(Status::internal, fmt::format("chunk {} of {} cannot be decoded", part, spec.path));
    const std::size_t begin = part * chunk.samples * each,
                      count = std::min(chunk.samples * each, all - begin);
    spec.put(std::span<const std::byte>(bytes).first(count * element_size(spec.type)), begin, all, samples);
  });
  return samples;
}

}  // namespace

std::optional<RecordHeader> read_record_header(std::span<const std::byte> bytes) {
  if (bytes.size() < record_header_bytes || load<std::uint32_t>(bytes.data()) != record_magic)
    return std::nullopt;
  if (load<std::uint32_t>(bytes.data() + 28) != crc32c(bytes.first(28))) return std::nullopt;
  const auto status = load<std::uint32_t>(bytes.data() + 4);
  if (status >= status_names.size()) return std::nullopt;
  return RecordHeader{load<std::uint64_t>(bytes.data() + 8), load<std::uint64_t>(bytes.data() + 16),
                      load<std::uint32_t>(bytes.data() + 24), static_cast<Status>(status)};
}

RecordParts split_record_head(const StoreHeader& header, std::span<const std::byte> payload) {
  Cursor cursor(payload);
  return take_head(header, cursor);
}

RecordParts split_record(const StoreHeader& header, std::span<const std::byte> payload) {
  Cursor cursor(payload);
  RecordParts parts = take_head(header, cursor);
  if (parts.status == Status::ok) {
    for_each_chunk(header, [&](const DatasetSpec& spec, const ChunkShape& chunk, std::uint32_t) {
      parts.samples.push_back(cursor.take(chunk.rows > 1 ? points_of(header, spec) * value_bytes(spec)
                                                         : std::size_t{cursor.take_length()}));
    });
    const auto names = cursor.take(item_record(header.columns).names_bytes(parts.items));
    parts.names = {reinterpret_cast<const char*>(names.data()), names.size()};
  }
  if (!cursor.at_end()) throw ItemError(Status::internal, "a journal record is longer than its parts");
  return parts;
}

std::size_t payload_head_bytes(const StoreHeader& header) {
  std::size_t bytes = item_record(header.columns).bytes + 4 + longest_reason;
  for (const DescriptorSchema& descriptor : header.descriptors) bytes += descriptor.width * sizeof(float);
  return bytes;
}

namespace {

void check_row(const StoreHeader& header, std::uint64_t row) {
  if (row >= header.ids.size())
    throw ItemError(Status::internal, fmt::format("row {} of a store of {} rows", row, header.ids.size()));
}

// Room for the record header, the item columns, and the reason.
void append_head(const StoreHeader& header, const ItemReport& report, std::vector<std::byte>& out) {
  out.resize(record_header_bytes + item_record(header.columns).bytes);
  for (const auto& [spec, offset] : item_record(header.columns).columns)
    spec->put_item(report, out.data() + record_header_bytes + offset);
  const std::string reason =
      report.status == Status::ok ? std::string() : clean_line(report.reason, longest_reason);
  append(out, static_cast<std::uint32_t>(reason.size()));
  const auto reason_bytes = std::as_bytes(std::span(reason));
  out.insert(out.end(), reason_bytes.begin(), reason_bytes.end());
}

// The names as a store of these columns has them.
std::string_view stored_names(const StoreHeader& header, Status status, std::string_view names) {
  if (status != Status::ok || !item_record(header.columns).names_offset) return {};
  if (names.size() > most_name_bytes)
    throw ItemError(Status::internal, fmt::format("a row has {} bytes of names", names.size()));
  return names;
}

EncodedRow encode(const StoreHeader& header, std::uint64_t row_number, const Row& row, Samples* spent) {
  check_row(header, row_number);
  ItemReport report = row.report;
  const std::string_view names = stored_names(header, report.status, row.names);
  report.names_bytes = static_cast<std::uint32_t>(names.size());
  const bool ok = report.status == Status::ok;
  check_samples(header, row.samples, report.status, ok ? header.samples : 0);
  check_descriptors(header, row);
  report.points_crc32c = ok ? crc32c(std::span<const float>(row.samples.points)) : 0;

  EncodedRow encoded;
  encoded.row = row_number;
  std::vector<std::byte>& out = encoded.bytes;
  // Filtered chunks are hardly larger.
  out.reserve(
      record_header_bytes + payload_head_bytes(header) +
      (ok ? row_bytes(header.columns, header.samples) + 2 * header.samples + 1024 + names.size() : 0));
  append_head(header, report, out);
  if (ok) {
    append_descriptors(header, row, out);
    append_samples(header, row.samples, spent, out);
    const auto name_bytes = std::as_bytes(std::span(names));
    out.insert(out.end(), name_bytes.begin(), name_bytes.end());
  }
  const std::span<const std::byte> payload = std::span<const std::byte>(out).subspan(record_header_bytes);
  write_record_header({row_number, payload.size(), crc32c(payload), report.status}, out);
  return encoded;
}

}  // namespace

RecordInParts::RecordInParts(const StoreHeader& header, std::uint64_t row, const ItemReport& report,
                             std::string_view names)
    : header_(header),
      row_(row),
      report_(report),
      names_(stored_names(header, report.status, names)),
      chunk_(sample_chunk(header.ids.size(), header.samples)) {
  report_.names_bytes = static_cast<std::uint32_t>(names_.size());
  check_row(header, row);
  if (chunk_.rows > 1 || !header.descriptors.empty() || header.columns->has_sets() ||
      report.status != Status::ok)
    throw ItemError(Status::internal, fmt::format("row {} cannot be encoded in parts", row));
}

std::uint64_t RecordInParts::begin_of(std::uint32_t part) const {
  return std::min<std::uint64_t>(std::uint64_t{part} * chunk_.samples, header_.samples);
}

RecordInParts::Part RecordInParts::encode(std::uint32_t part, const Samples& samples) const {
  const std::size_t count = end_of(part) - begin_of(part);
  check_samples(header_, samples, report_.status, count);
  Part made;
  made.bytes.reserve(row_bytes(header_.columns, chunk_.samples) + 2 * chunk_.samples + 1024);
  for (const DatasetSpec& spec : datasets_of(header_.columns))
    if (spec.role == Role::samples)
      append_chunk(spec, chunk_, spec.view(samples), header_.compression, made.bytes);
  made.crc32c = crc32c(made.bytes);
  made.points_crc32c = crc32c(std::span<const float>(samples.points));
  made.points_bytes = samples.points.size() * sizeof(float);
  return made;
}

void RecordInParts::add(const Part& part) {
  crc32c_ = crc32c_joined(crc32c_, part.crc32c, part.bytes.size());
  points_crc32c_ = crc32c_joined(points_crc32c_, part.points_crc32c, part.points_bytes);
  bytes_ += part.bytes.size();
  ++added_;
}

std::span<const std::byte> RecordInParts::take_names() {
  const auto bytes = std::as_bytes(std::span(names_));
  names_ = {};
  crc32c_ = crc32c_joined(crc32c_, crc32c(bytes), bytes.size());
  bytes_ += bytes.size();
  return bytes;
}

std::size_t RecordInParts::head_bytes() const {
  return record_header_bytes + item_record(header_.columns).bytes + 4;  // no reason
}

std::vector<std::byte> RecordInParts::head() const {
  if (added_ != parts())
    throw ItemError(Status::internal,
                    fmt::format("row {} has {} parts instead of {}", row_, added_, parts()));
  ItemReport report = report_;
  report.points_crc32c = points_crc32c_;
  std::vector<std::byte> head;
  append_head(header_, report, head);
  const std::uint32_t crc = crc32c(std::span<const std::byte>(head).subspan(record_header_bytes));
  write_record_header({row_, payload_bytes(), crc32c_joined(crc, crc32c_, bytes_), report.status}, head);
  return head;
}

std::uint64_t RecordInParts::payload_bytes() const { return head_bytes() - record_header_bytes + bytes_; }

}  // namespace store

EncodedRow encode_row(const StoreHeader& header, std::uint64_t row_number, const Row& row) {
  return store::encode(header, row_number, row, nullptr);
}

EncodedRow encode_row(const StoreHeader& header, std::uint64_t row_number, Row&& row) {
  return store::encode(header, row_number, row, &row.samples);
}

EncodedRow encode_row_in_blocks(const StoreHeader& header, std::uint64_t row_number, const ItemReport& report,
                                SampleBlocks blocks, std::string names) {
  store::RecordInParts(header, row_number, report, names);  // throws unless it can be
  return {row_number, {}, std::move(blocks), report, std::move(names)};
}

EncodedRow encode_row(const StoreHeader& header, std::uint64_t row_number, CopiedRow copied) {
  return copied.blocks ? encode_row_in_blocks(header, row_number, copied.row.report, std::move(copied.blocks),
                                              std::move(copied.row.names))
                       : encode_row(header, row_number, std::move(copied.row));
}

Row decode_row(const StoreHeader& header, const EncodedRow& encoded) {
  using namespace store;
  const std::span<const std::byte> bytes(encoded.bytes);
  const auto facts = read_record_header(bytes);
  if (!facts || facts->row != encoded.row || facts->payload_bytes != bytes.size() - record_header_bytes ||
      facts->payload_crc32c != crc32c(bytes.subspan(record_header_bytes)) || encoded.row >= header.ids.size())
    throw ItemError(Status::internal, fmt::format("the encoded row {} is damaged", encoded.row));
  const RecordParts parts = split_record(header, bytes.subspan(record_header_bytes));
  Row row;
  for (const auto& [spec, offset] : item_record(header.columns).columns)
    spec->get_item(parts.items.data() + offset, row.report);
  row.report.reason = parts.reason;
  if (parts.status != Status::ok) return row;
  row.samples = decode_samples(header, parts);
  row.names = parts.names;
  for (std::size_t i = 0; i < parts.descriptors.size(); ++i) {
    DescriptorRow& descriptor = row.descriptors.emplace_back();
    descriptor.name = header.descriptors[i].name;
    descriptor.values.resize(header.descriptors[i].width);
    std::memcpy(descriptor.values.data(), parts.descriptors[i].data(), parts.descriptors[i].size());
  }
  return row;
}

}  // namespace meander
