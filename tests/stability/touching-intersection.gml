% solids that touch seem to share what has no thickness
%
% The intersection of solids that share a face, a line or a point is empty.
#include "common.gml"

{ /name /a /b
  a b intersect 25.0 rotatex 35.0 rotatey 0.0 0.0 2.0 translate 60.0 49 49 name flat apply
} /meet
orange matte apply cube blue matte apply cube 1.0 0.0 0.0 translate "cubes.ppm" meet apply
orange matte apply cylinder blue matte apply cylinder 0.0 -1.0 0.0 translate "discs.ppm" meet apply
orange matte apply cone blue matte apply plane "apex.ppm" meet apply
orange matte apply sphere blue matte apply plane 0.0 -1.0 0.0 translate "ball.ppm" meet apply
orange matte apply plane blue matte apply plane 60.0 rotatex 120.0 rotatex "planes.ppm" meet apply
