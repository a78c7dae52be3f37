#include "io/store/store_merge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "io/store/chunk_codec.h"

namespace meander::store {

namespace fs = std::filesystem;

namespace {

RowRange rows_of_shard(const StoreLayout& layout, std::size_t shard) {
  return {shard * shard_rows, std::min<std::uint64_t>(layout.rows, (shard + 1) * shard_rows)};
}

[[noreturn]] void refuse_shard(const fs::path& path, std::string_view why) {
  throw RunError(RunError::Kind::unusable,
                 fmt::format("{} is damaged ({}): remove it and run again, its rows will be computed again",
                             path.string(), why));
}

// Opens a shard and calls body(reader); what cannot be read is damage to the shard.
template <class Body>
void with_shard(const fs::path& path, const StoreLayout& layout, RowRange rows, const Body& body) {
  const Hdf5Lock lock;
  try {
    const StoreFileReader reader(path);
    if (!reader.problems().empty()) refuse_shard(path, reader.problems().front());
    const auto& shard = reader.facts().shard;
    if (!shard || shard->begin != rows.begin || shard->end != rows.end ||
        reader.layout().rows != layout.rows || reader.layout().samples != layout.samples ||
        reader.layout().datasets.size() != layout.datasets.size())
      refuse_shard(path, "it belongs to another run");
    body(reader);
  } catch (const Hdf5Error& error) {
    refuse_shard(path, error.what());
  }
}

std::vector<std::byte> read_statuses(const StoreFileReader& reader, const StoreLayout& layout,
                                     RowRange rows) {
  std::vector<std::byte> statuses(rows.size());
  reader.read_rows(layout.index_of(ElementType::status), 0, rows.size(), statuses);
  return statuses;
}

// Chunks of samples and descriptors without a row that is ok were never written.
void copy_chunks(const StoreFileReader& reader, StoreFileWriter& store, const DatasetLayout& dataset,
                 std::size_t index, RowRange rows, const std::vector<std::byte>& statuses,
                 std::vector<std::byte>& buffer) {
  const bool always = dataset.spec.role != Role::samples && dataset.spec.role != Role::descriptor;
  for (std::uint64_t row = 0; row < rows.size(); row += dataset.chunk.rows) {
    const auto begin = statuses.begin() + static_cast<std::ptrdiff_t>(row);
    const auto end =
        statuses.begin() + static_cast<std::ptrdiff_t>(std::min(row + dataset.chunk.rows, rows.size()));
    if (!always && std::find(begin, end, static_cast<std::byte>(Status::ok)) == end) continue;
    for (std::uint32_t part = 0; part < dataset.chunk.chunks_per_row; ++part) {
      reader.read_chunk(index, row, part, buffer);
      store.write_chunk(index, rows.begin + row, part, buffer);
    }
  }
}

// Reasons are wider in the store than in the shard: the one column that is not copied as it is.
void widen_reasons(const StoreFileReader& reader, StoreFileWriter& store, const StoreLayout& layout,
                   std::size_t index, RowRange rows) {
  const DatasetLayout& dataset = layout.datasets[index];
  const std::uint32_t width = reader.layout().datasets[index].text_width;
  std::vector<std::byte> narrow(rows.size() * width), wide(dataset.chunk_bytes), filtered;
  reader.read_rows(index, 0, rows.size(), narrow);
  if (std::all_of(narrow.begin(), narrow.end(), [](std::byte b) { return b == std::byte{}; })) return;
  for (std::uint64_t row = 0; row < rows.size(); ++row)
    std::memcpy(wide.data() + row * dataset.text_width, narrow.data() + row * width, width);
  append_filtered(wide, dataset.element_bytes, layout.compression, filtered);
  store.write_chunk(index, rows.begin, 0, filtered);
}

}  // namespace

void merge_shards(const fs::path& path, const StoreHeader& header, const StoreLayout& shard_layout,
                  const std::vector<fs::path>& shards) {
  StoreLayout layout = shard_layout;
  const std::size_t reason = layout.index_of(Role::reason);
  std::uint32_t reason_width = 1;
  std::uint64_t bytes = std::uint64_t{256} * 1024;
  for (std::size_t s = 0; s < shards.size(); ++s) {
    if (const std::string damage = check_whole_file(shards[s]); !damage.empty())
      refuse_shard(shards[s], damage);
    with_shard(shards[s], layout, rows_of_shard(layout, s), [&](const StoreFileReader& reader) {
      reason_width = std::max(reason_width, reader.layout().datasets[reason].text_width);
    });
    bytes += fs::file_size(shards[s]);
  }
  set_text_width(layout.datasets[reason], reason_width);
  bytes += shards.size() * layout.datasets[reason].chunk_bytes;

  StoreFileWriter store(path, layout, header, std::nullopt, bytes);
  std::vector<std::byte> buffer;
  // Small columns first, so that they are contiguous at the front of the file; then the samples.
  for (const bool samples : {false, true})
    for (std::size_t s = 0; s < shards.size(); ++s) {
      const RowRange rows = rows_of_shard(layout, s);
      with_shard(shards[s], layout, rows, [&](const StoreFileReader& reader) {
        const std::vector<std::byte> statuses = read_statuses(reader, layout, rows);
        for (std::size_t d = 0; d < layout.datasets.size(); ++d) {
          if (per_sample(layout.datasets[d].spec) != samples) continue;
          if (d == reason)
            widen_reasons(reader, store, layout, d, rows);
          else
            copy_chunks(reader, store, layout.datasets[d], d, rows, statuses, buffer);
        }
      });
    }
  store.seal();
}

}  // namespace meander::store
