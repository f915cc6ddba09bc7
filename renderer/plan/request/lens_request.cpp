#include "plan/request/lens_request.h"

#include <type_traits>

namespace clerestory {

std::string_view typeOf(const LensRequest& lens) {
    return std::visit([](const auto& held) { return std::decay_t<decltype(held)>::kType; }, lens);
}

}  // namespace clerestory
