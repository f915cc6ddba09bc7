// Memory of this process.
#pragma once

namespace clerestory {

double residentBytes();  // in RAM; 0 if unknown
// Allocated by the program and its libraries, without the free memory of the allocator.
double allocatedBytes();

// Returns the free memory of the allocator to the system, and the pages of the shader compiler's
// code, which are read again from its file on demand.
void releaseUnusedMemory();

}  // namespace clerestory
