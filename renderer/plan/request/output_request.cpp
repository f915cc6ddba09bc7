#include "plan/request/output_request.h"

namespace clerestory {

std::uint32_t channelsOf(Channel channel) {
    const bool isVector = channel == Channel::color || channel == Channel::normal ||
                          channel == Channel::position || channel == Channel::albedo ||
                          channel == Channel::flow;
    return isVector ? 3 : 1;
}

bool hasLayers(Channel channel) {
    switch (channel) {
        case Channel::depth:
        case Channel::normal:
        case Channel::position:
        case Channel::albedo:
        case Channel::objectId:
        case Channel::materialId:
        case Channel::classId:
            return true;
        case Channel::color:
        case Channel::through:
        case Channel::flow:
        case Channel::instances:
            break;
    }
    return false;
}

}  // namespace clerestory
