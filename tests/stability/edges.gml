% a ray through an edge is inside for no time, or for an error's time
%
% The edges of a cube's front lie on pixel centres, where rays leave as they enter: they miss.
#include "common.gml"

orange matte apply cube -0.5 -0.5 0.0 translate 0.9375 0.9375 1.0 scale
90.0 32 32 "edges.ppm" flat apply
