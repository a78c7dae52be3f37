#include "io/mesh/tensor_table.h"

#include "support/catch.h"
#include "support/mesh_files.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

TensorTable read(const std::string& text) {
  const ScratchFolder folder;
  write_file(folder / "table.txt", text);
  return read_tensor_table(folder / "table.txt");
}

void check_fails(const std::string& text, Status status, const std::string& sentence) {
  CAPTURE(text);
  try {
    read(text);
    FAIL("nothing was thrown");
  } catch (const ItemError& error) {
    CHECK(error.status() == status);
    CHECK_THAT(error.what(), ContainsSubstring(sentence));
  }
}

}  // namespace

TEST_CASE("read_tensor_table: rows of six or three numbers, comments, blank lines") {
  const TensorTable six =
      read("# xx xy xz yy yz zz\n1 0 0 2 0 3\n\n\t4.5 0 -1e-3 2 0 3  # second\r\n1 0 0 1 0 1");
  CHECK(six.columns == 6);
  CHECK(six.row_count() == 3);
  CHECK(six.values[6] == 4.5);
  CHECK(six.values[8] == -1e-3);
  const TensorTable three = read(
      "\xEF\xBB\xBF"
      "1 2 3\r\n4 5 6\r\n");
  CHECK(three.columns == 3);
  CHECK(three.row_count() == 2);
  CHECK(three.values == std::vector<double>{1, 2, 3, 4, 5, 6});
}

TEST_CASE("read_tensor_table: errors name the line") {
  check_fails("", Status::empty, "no row");
  check_fails("# nothing\n\n", Status::empty, "no row");
  check_fails("1 2 3\n# x\n1 2\n", Status::unreadable, "line 3: 2 numbers, but the first row has 3");
  check_fails("1 2 3 4\n", Status::unreadable, "line 1: 4 numbers, but a row has six");
  check_fails("1 2 3 4 5 6 7\n", Status::unreadable, "line 1: 7 numbers");
  check_fails("1 2 3\n1 two 3\n", Status::unreadable, "line 2: `two` is not a number");
  check_fails("1,2,3\n", Status::unreadable, "is not a number");
}
