#include "plan/graph/pass.h"

#include <algorithm>

namespace clerestory {

std::string_view Pass::kind() const {
    return std::visit([](const auto& w) { return w.kind(); }, work);
}

std::vector<TargetId> Pass::reads() const {
    return std::visit([](const auto& w) { return w.reads(); }, work);
}

std::string_view Pass::knobs() const {
    return std::visit([](const auto& w) { return w.knobs(); }, work);
}

const View* Pass::view() const {
    return std::visit(
        [](const auto& w) -> const View* {
            if constexpr (requires { w.view; })
                return &w.view;
            else
                return nullptr;
        },
        work);
}

std::string_view Pass::map() const {
    return std::visit(
        [](const auto& w) -> std::string_view {
            if constexpr (requires { w.map; })
                return w.map;
            else
                return {};
        },
        work);
}

std::vector<std::span<const Draw>> Pass::drawLists() const {
    return std::visit(
        [](const auto& w) -> std::vector<std::span<const Draw>> {
            if constexpr (requires { w.drawLists(); })
                return w.drawLists();
            else
                return {};
        },
        work);
}

const RecordedDraws* Pass::recorded() const {
    return std::visit(
        [](const auto& w) -> const RecordedDraws* {
            if constexpr (requires { w.recorded; })
                return &w.recorded;
            else
                return nullptr;
        },
        work);
}

std::uint32_t Pass::face() const {
    return std::visit(
        [](const auto& w) -> std::uint32_t {
            if constexpr (requires { w.face; })
                return w.face;
            else
                return 0;
        },
        work);
}

bool followsRays(const Pass& pass) {
    const auto lists = pass.drawLists();
    return std::any_of(lists.begin(), lists.end(), [](std::span<const Draw> draws) {
        return std::any_of(draws.begin(), draws.end(),
                           [](const Draw& draw) { return followsRays(draw); });
    });
}

OutputLayer layerOf(const Pass& pass) {
    return std::visit(
        [](const auto& w) {
            if constexpr (requires { w.layer; })
                return w.layer;
            else
                return OutputLayer::direct;
        },
        pass.work);
}

std::string_view nameOf(Effect effect) {
    switch (effect) {
        case Effect::base:
            return "base";
        case Effect::emission:
            return "emission";
        case Effect::refraction:
            return "refraction";
        case Effect::planarReflection:
            return "planarReflection";
        case Effect::environmentReflection:
            return "environmentReflection";
        case Effect::materialLayers:
            return "materialLayers";
        case Effect::shadows:
            return "shadows";
        case Effect::indirectLight:
            return "indirectLight";
        case Effect::filters:
            return "filters";
    }
    return "";
}

}  // namespace clerestory
