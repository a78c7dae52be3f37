#include "jobs/store_items.h"

#include <charconv>
#include <filesystem>

#include "io/item_id.h"
#include "jobs/inputs.h"

namespace meander {

std::uint64_t find_item(const StoreReader& store, const std::string& item) {
  if (const auto row = store.find(item)) return *row;
  if (const auto row = store.find(escape_id(item))) return *row;
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(item.data(), item.data() + item.size(), number);
  if (error == std::errc() && end == item.data() + item.size() && number < store.rows()) return number;
  throw UsageError("no item `" + item + "` (neither an id nor a row number below " +
                   std::to_string(store.rows()) + ")");
}

void keep_store(const std::string& store, std::initializer_list<std::string> outputs) {
  for (const std::string& output : outputs) {
    std::error_code none;
    if (!output.empty() && std::filesystem::equivalent(output, store, none))
      throw UsageError("`" + output + "` is the store itself: it would be replaced");
  }
}

}  // namespace meander
