// Memory of this process.
#pragma once

namespace clerestory {

double residentBytes();  // in RAM now; 0 where the system does not tell

}  // namespace clerestory
