// Passes that move pictures about without drawing the scene.
#include "passes/passes.h"

namespace clerestory {

void execute(PassResources&, const PassInput& input, const CopyBackdrop& work) {
    input.read(work.source).readable(work.face).resolveInto(input.target().drawn());
    input.target().makeLevels();
}

void execute(PassResources&, const PassInput& input, const BuildLevels&) {
    input.target().makeLevels();
}

}  // namespace clerestory
