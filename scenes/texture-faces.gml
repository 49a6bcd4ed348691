% texture-faces.gml - the five primitives, each showing its face, u and v (Chicago dialect).
%
% Left to right cylinder, sphere, cone (standing on its apex) and cube; the floor is the plane.
% Red grows with u, green with v, and a dark line is drawn at every eighth. The face is what
% sets the blue: none on face 0, more for each further one. A black mirror at the back (black
% mirrors are perfect in this dialect) shows the faces we cannot see. u has its seam at
% +z, the back; the sphere is turned round to have it in front.
%
%              face 0         1           2          3       4     5        u, v of the sides
%   sphere     all                                                          angle, height
%   cube       z = 0          z = 1       x = 0      x = 1   top   bottom   edges
%   cylinder   side           top         bottom                            angle, height
%   cone       side           base                                          angle, height
%   plane      all                                                          x and z, unbounded

#include "lib/surfaces.ins"

% t lined -> bool: is t close to a multiple of 1/8 ?
{ /t
  t 8.0 mulf 0.06 addf frac 0.12 lessf
} /lined

{ /v /u /face
  u lined apply { true } { v lined apply } if { 0.35 } { 1.0 } if /ink
  u ink mulf v ink mulf face real 0.24 mulf ink mulf point
  0.92 0.08 40.0
} /chart

% On the plane u and v go on for ever: the chart repeats, paler, in every unit square
{ /v /u /face
  u u floor real subf /a
  v v floor real subf /b
  a 0.03 lessf { true } { b 0.03 lessf } if { 0.15 } { 0.75 } if /ink
  0.2 a 0.6 mulf addf ink mulf 0.2 b 0.6 mulf addf ink mulf 0.2 ink mulf point
  1.0 0.0 1.0
} /plan

chart cylinder 0.55 1.2 0.55 scale -2.2 0.0 0.2 translate
chart sphere 0.62 uscale 180.0 rotatey -0.75 0.62 0.0 translate union
chart cone 0.6 1.25 0.6 scale 0.72 0.0 0.0 translate union
chart cube 1.0 uscale 28.0 rotatey 1.6 0.0 0.0 translate union
plan plane union
0.0 0.0 0.0 point 0.0 0.8 400.0 plain apply
  cube -0.5 0.0 0.0 translate 6.4 2.5 0.1 scale 0.0 0.0 2.0 translate union
-22.0 rotatex 0.0 -0.25 4.3 translate /table

0.5 0.5 0.5 point
[ -3.0 5.0 -2.0 point  0.9 0.9 0.9 point  pointlight
   2.0 4.0 -1.0 point  0.35 0.35 0.35 point  pointlight ]
1.0 0.0 0.005 point
table 3 58.0 320 240 "texture-faces.ppm" render
