#include "plan/graph/subject.h"

namespace clerestory {

std::string_view nameOf(Subject::Kind kind) {
    switch (kind) {
        case Subject::Kind::view:
            return "view";
        case Subject::Kind::environment:
            return "environment";
        case Subject::Kind::map:
            return "map";
        case Subject::Kind::mirror:
            return "mirror";
        case Subject::Kind::probe:
            return "probe";
        case Subject::Kind::glass:
            return "glass";
        case Subject::Kind::lights:
            return "lights";
        case Subject::Kind::filter:
            return "filter";
    }
    return "";
}

std::string nameOf(const Subject& subject) {
    if (subject.kind == Subject::Kind::view) {
        return subject.name.empty() ? "surface" : "surface:" + subject.name;
    }
    std::string name(nameOf(subject.kind));
    if (subject.kind == Subject::Kind::filter) name += std::to_string(subject.index);
    return name + ":" + subject.name;
}

}  // namespace clerestory
