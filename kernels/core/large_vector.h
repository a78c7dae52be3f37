// Vectors of many megabytes. The system gives their memory page by page where it is first written, which
// takes longer than the writing, and a vector is first written by one thread. Here the pages are fetched by
// all threads.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

namespace meander {

// Fetches the pages of memory that will be written. It may do nothing: what is not fetched comes with the
// first write. For blocks of several megabytes, which allocators ask the system for.
void fetch_pages(void* memory, std::size_t bytes);

// reserve(), resize() and make_unique_for_overwrite() of memory that will be written as a whole.
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
// `next` behind what is there; large ones want capacity for it.
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
