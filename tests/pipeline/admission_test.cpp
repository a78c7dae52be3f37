#include "pipeline/admission.h"

#include <algorithm>
#include <map>
#include <vector>

#include "kernels/core/random.h"
#include "support/catch.h"

using namespace meander;

TEST_CASE("admission: the largest item goes first, equal ones in plan order") {
  Admission admission(1000, 10, false);
  admission.add(0, 10);
  admission.add(1, 300);
  admission.add(2, 300);
  CHECK(admission.next()->item == 1);
  CHECK(admission.next()->item == 2);
  CHECK(admission.next()->item == 0);
  CHECK_FALSE(admission.next());
  CHECK(admission.bytes_in_flight() == 610);
}

TEST_CASE("admission: no more items in flight than allowed") {
  Admission admission(1000, 2, false);
  for (std::size_t i = 0; i < 5; ++i) admission.add(i, 1);
  const auto first = admission.next();
  CHECK(admission.next());
  CHECK_FALSE(admission.next());
  admission.release(*first);
  CHECK(admission.next());
}

TEST_CASE("admission: an item above the whole budget is too large, or runs alone if allowed") {
  Admission strict(100, 4, false);
  CHECK(strict.too_large(101));
  CHECK_FALSE(strict.too_large(100));
  Admission lenient(100, 4, true);
  CHECK_FALSE(lenient.too_large(101));
  lenient.add(0, 500);
  lenient.add(1, 50);
  const auto giant = lenient.next();
  CHECK(giant->item == 0);
  CHECK_FALSE(lenient.next());
  lenient.release(*giant);
  CHECK(lenient.next()->item == 1);
}

TEST_CASE("admission: small items run beside a large one and never delay a waiting large one") {
  Admission admission(100, 100, false);
  admission.add(0, 80);
  admission.add(1, 70);  // does not fit beside item 0: waits
  for (std::size_t i = 2; i < 50; ++i) admission.add(i, 10);
  const auto first = admission.next();
  REQUIRE(first->item == 0);
  std::vector<Admission::Ticket> ahead;
  while (const auto ticket = admission.next()) ahead.push_back(*ticket);
  CHECK(ahead.size() == 2);  // 20 bytes are free, and 30 would be beside the large item
  // Small items keep ending and starting while the first large item runs: the waiting one must start as soon
  // as it ends.
  for (int round = 0; round < 10; ++round) {
    admission.release(ahead.back());
    ahead.pop_back();
    while (const auto ticket = admission.next()) ahead.push_back(*ticket);
    CHECK(ahead.size() <= 3);
  }
  admission.release(*first);
  CHECK(admission.next()->item == 1);
}

TEST_CASE("admission: random loads never exceed the budget and all items come out once") {
  const RandomKey key = make_random_key(1, {});
  Admission admission(1000, 6, false);
  std::map<std::size_t, int> seen;
  for (std::size_t i = 0; i < 2000; ++i) {
    const double u = random_pair(key, Stream::sequence, i).first;
    admission.add(i, 1 + static_cast<std::uint64_t>(999 * u * u * u));
  }
  std::vector<Admission::Ticket> running;
  for (std::uint32_t step = 0; admission.waiting() > 0 || !running.empty(); ++step) {
    while (const auto ticket = admission.next()) {
      running.push_back(*ticket);
      ++seen[ticket->item];
    }
    REQUIRE(admission.bytes_in_flight() <= 1000);
    REQUIRE(!running.empty());
    const std::size_t ended = random_words(key, Stream::leaf_ray, step)[0] % running.size();
    admission.release(running[ended]);
    running.erase(running.begin() + static_cast<std::ptrdiff_t>(ended));
  }
  CHECK(seen.size() == 2000);
  CHECK(std::all_of(seen.begin(), seen.end(), [](const auto& entry) { return entry.second == 1; }));
  CHECK(admission.bytes_in_flight() == 0);
  CHECK(admission.items_in_flight() == 0);
}
