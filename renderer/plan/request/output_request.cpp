#include "plan/request/output_request.h"

namespace clerestory {

std::uint32_t channelsOf(Channel channel) {
    const bool isVector = channel == Channel::color || channel == Channel::normal ||
                          channel == Channel::position || channel == Channel::albedo ||
                          channel == Channel::flow;
    return isVector ? 3 : 1;
}

bool hasLayers(Channel channel) {
    return channel != Channel::color && channel != Channel::through;
}

}  // namespace clerestory
