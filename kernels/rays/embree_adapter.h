// The only file that includes Embree. Everything that differs between Embree 3 and 4 is in here: the header,
// the context of a query, and the call that traces a packet.
#pragma once

#if MEANDER_EMBREE_MAJOR == 3
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif

#include <mutex>
#include <string>

#include "kernels/rays/embree_device.h"

namespace meander {

struct EmbreeDevice::Handle {
  RTCDevice device = nullptr;
  std::mutex mutex;          // guards last_message
  std::string last_message;  // of the newest error of any thread
};

// Rays of a packet. Where the instruction set is narrower Embree cuts the packet itself.
inline constexpr unsigned packet_width = 16;
using RayPacket = RTCRay16;

#if MEANDER_EMBREE_MAJOR == 3
using EmbreeContext = RTCIntersectContext;
#else
using EmbreeContext = RTCRayQueryContext;
#endif

// What a query carries to the filter function: the context must stay the first member.
struct QueryContext {
  EmbreeContext embree;
  void* record = nullptr;
};

// The record of the query that called a filter function.
inline void* record_of(const RTCFilterFunctionNArguments* arguments) {
  return reinterpret_cast<QueryContext*>(arguments->context)->record;
}

// Any-hit traversal of coherent rays: nothing is sorted by distance, and a ray ends early only when its
// filter, which finds `record`, accepts a hit.
inline void trace_packet(const int* valid, RTCScene scene, void* record, RayPacket& rays) {
  QueryContext query;
  query.record = record;
#if MEANDER_EMBREE_MAJOR == 3
  rtcInitIntersectContext(&query.embree);
  query.embree.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcOccluded16(valid, scene, &query.embree, &rays);
#else
  rtcInitRayQueryContext(&query.embree);
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  arguments.context = &query.embree;
  rtcOccluded16(valid, scene, &rays, &arguments);
#endif
}

// Turns the error that Embree kept for this thread, if any, into an exception: ItemError(out_of_memory) or
// std::logic_error. `doing` says what was being tried.
void throw_embree_error(EmbreeDevice::Handle& handle, const char* doing);

}  // namespace meander
