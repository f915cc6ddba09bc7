// Whether this build uses a sanitizer, which reserves terabytes of address space and makes
// additional system calls, and fails if either is limited.
#pragma once

namespace clerestory {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace clerestory
