// Ids of items: reversible, valid UTF-8, and the names themselves where these are ordinary.
#include "io/item_id.h"

#include <random>
#include <set>
#include <string>

#include "io/utf8.h"
#include "support/catch.h"

using namespace meander;

namespace {

bool is_clean(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = utf8_sequence_length(text);
    if (length == 0) return false;
    const auto first = static_cast<unsigned char>(text[0]),
               second = static_cast<unsigned char>(text[length / 2]);
    if (length == 1 && (first < 0x20 || first == 0x7F)) return false;
    if (length == 2 && first == 0xC2 && second < 0xA0) return false;
    text.remove_prefix(length);
  }
  return true;
}

}  // namespace

TEST_CASE("item id: ordinary names are unchanged") {
  for (const char* name : {"chair/train/chair_0001.off", "a b (1) [x] {y} 'z'.OBJ", "50%.off", "100%/x.off",
                           "a%20b.off", "%zz %4 %", "%c3%a9.off", "caf\xC3\xA9/\xE6\xA4\x85\xE5\xAD\x90.ply",
                           "\xF0\x9F\xAA\x91.stl", "a\\b\"c.off"})
    CHECK(escape_id(name) == name);
}

TEST_CASE("item id: reserved bytes are escaped") {
  CHECK(escape_id("caf\xE9.off") == "caf%E9.off");
  CHECK(escape_id("a\nb\tc\x7F") == "a%0Ab%09c%7F");
  CHECK(escape_id(std::string("\0", 1)) == "%00");
  CHECK(escape_id("\xC2\x9B") == "%C2%9B");
  CHECK(escape_id("\xED\xA0\x80") == "%ED%A0%80");
  CHECK(escape_id("\xC3") == "%C3");
  CHECK(escape_id("%E9 %25 %0A %7F") == "%25E9 %2525 %250A %257F");
}

TEST_CASE("item id: every name can be recovered, and no two names share an id") {
  std::mt19937_64 random(5);
  // Few different bytes, so that escapes, halves of escapes and sequences are adjacent.
  const std::string bytes = "%%%%2505EFfa/ \n\xC3\xA9\xFF\xC2\x80\x7F";
  std::set<std::string> names, ids;
  for (int i = 0; i < 200000; ++i) {
    std::string name(random() % 9, '\0');
    for (char& c : name) c = i % 2 == 0 ? bytes[random() % bytes.size()] : static_cast<char>(random());
    const std::string id = escape_id(name);
    if (unescape_id(id) != name || !is_clean(id)) FAIL("`" << id << "`");
    names.insert(name);
    ids.insert(id);
  }
  CHECK(names.size() == ids.size());
}
