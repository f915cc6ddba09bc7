// Embree 3 (Debian 12, Ubuntu 24.04) or 4 (Debian 13), and what differs between the two.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace clerestory::embree {

#if RTC_VERSION_MAJOR >= 4

using QueryContext = RTCRayQueryContext;

inline void intersect(RTCScene scene, QueryContext& context, RTCRayHit& query) {
    rtcInitRayQueryContext(&context);
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context;
    rtcIntersect1(scene, &query, &arguments);
}

inline void occluded(RTCScene scene, QueryContext& context, RTCRay& query) {
    rtcInitRayQueryContext(&context);
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &context;
    rtcOccluded1(scene, &query, &arguments);
}

#else

using QueryContext = RTCIntersectContext;

inline void intersect(RTCScene scene, QueryContext& context, RTCRayHit& query) {
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, &query);
}

inline void occluded(RTCScene scene, QueryContext& context, RTCRay& query) {
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene, &context, &query);
}

#endif

}  // namespace clerestory::embree
