// Passes that move pictures about without drawing the scene.
#include "passes/passes.h"

namespace clerestory {

void runBackdropPass(const PassInput& input) {
    input.read(0).readable(input.pass.face).resolveInto(input.target().drawn());
    input.target().makeLevels();
}

void runLevelsPass(const PassInput& input) {
    input.target().makeLevels();
}

}  // namespace clerestory
