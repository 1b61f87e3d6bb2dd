// candidate_search.h: the pairs of spent blocks, found anew. For detect/candidates.c alone.
//
//   in   trees over the cloth's triangles and edges, ways of the points, blocks
//   out  the pairs of the blocks' items that end or pass each other within reach and margin

#ifndef PERCALE_CANDIDATE_SEARCH_H
#define PERCALE_CANDIDATE_SEARCH_H

#include "detect/candidates.h"

/// False without memory: then some blocks have lost their pairs.
bool percale_candidates_search(PercaleCandidates *candidates, const PercaleCandidateStage *stage,
                               uint64_t *tested);

#endif
