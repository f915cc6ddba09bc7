// Whether this build carries a sanitizer, which reserves terabytes of addresses and makes system
// calls of its own: limits on either would be its end.
#pragma once

namespace clerestory {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace clerestory
