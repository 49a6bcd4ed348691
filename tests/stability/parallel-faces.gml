% a ray in the plane of a face is inside for all t, or 0 times infinity
%
% Four beams that meet in a line through the eye are one beam, seen end on.
#include "common.gml"

orange matte apply cube 0.5 0.5 4.0 scale /beam
{ /name /object
  sun 0.2 0.2 0.2 point object name lit apply
} /shown
orange matte apply cube 1.0 1.0 4.0 scale -0.5 -0.5 0.0 translate "one.ppm" shown apply
beam beam -0.5 0.0 0.0 translate union beam 0.0 -0.5 0.0 translate union
beam -0.5 -0.5 0.0 translate union "four.ppm" shown apply
