#include "io/mesh/tensor_table.h"

#include <algorithm>
#include <string>
#include <string_view>

#include "io/file/file_bytes.h"
#include "io/mesh/text_cursor.h"
#include "io/utf8.h"

namespace meander {

TensorTable read_tensor_table(const std::filesystem::path& path, const CancelToken& cancel) {
  const FileBytes file(path);
  std::string_view content = text_of(file.bytes());
  content = without_byte_order_mark(content);
  TensorTable table;
  table.columns = 0;
  std::size_t row = 0;
  text::TextCursor cursor{content.data(), content.data() + content.size()};
  while (cursor.skip_to_token()) {
    if ((row++ & 0xFFFF) == 0) cancel.check();
    const char* const line = cursor.at;
    unsigned count = 0;
    for (; cursor.token_on_line(); ++count) {
      double value = 0;
      if (cursor.number(value) != text::Token::ok)
        text::fail_at(content, cursor.at, text::quoted(content, cursor.at) + " is not a number");
      if (count < 6) table.values.push_back(value);
    }
    if (table.columns == 0) {
      if (count != 3 && count != 6)
        text::fail_at(content, line,
                      std::to_string(count) + (count == 1 ? " number" : " numbers") +
                          ", but a row has six (a tensor) or three (a vector)");
      table.columns = count;
    }
    if (count != table.columns)
      text::fail_at(content, line,
                    std::to_string(count) + (count == 1 ? " number" : " numbers") +
                        ", but the first row has " + std::to_string(table.columns));
  }
  if (table.columns == 0) throw ItemError(Status::empty, "the tensor table has no row");
  return table;
}

}  // namespace meander
