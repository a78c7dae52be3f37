// Vectors of many megabytes. The system maps their pages one by one at the first write, which takes longer
// than the writing itself and is done by the one thread that writes first. These functions fetch the pages
// with all threads.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

namespace meander {

// Fetches the pages of memory that will be written. This is only a hint: pages that are not fetched come with
// the first write. It pays for blocks of several megabytes, which allocators ask the system for.
void fetch_pages(void* memory, std::size_t bytes);

// reserve(), resize(), assign() and make_unique_for_overwrite() for memory that will be written as a whole.
template <class T>
void reserve_large(std::vector<T>& vector, std::size_t count) {
  if (count <= vector.capacity()) return;
  vector.reserve(count);
  fetch_pages(vector.data(), count * sizeof(T));
}
template <class T>
void resize_large(std::vector<T>& vector, std::size_t count) {
  reserve_large(vector, count);
  vector.resize(count);
}
template <class T>
void assign_large(std::vector<T>& vector, std::size_t count, const T& value) {
  reserve_large(vector, count);
  vector.assign(count, value);
}
// Appends `next`; large vectors should have capacity for it.
template <class T>
void append_large(std::vector<T>& vector, const std::vector<T>& next) {
  if (vector.capacity() - vector.size() >= next.size())
    fetch_pages(vector.data() + vector.size(), next.size() * sizeof(T));
  vector.insert(vector.end(), next.begin(), next.end());
}
template <class T>
std::unique_ptr<T[]> make_large(std::size_t count) {
  auto array = std::make_unique_for_overwrite<T[]>(count);
  fetch_pages(array.get(), count * sizeof(T));
  return array;
}

}  // namespace meander
