% icfp-tint.gml - metals: the ICFP dialect tints highlight and reflection (ICFP dialect).
%
% Everything around is black, white or grey, and so are the lamps. All terms of the ICFP
% equation are multiplied by the colour of the surface, hence what gold reflects is golden,
% twice so if gold reflects gold. (Add an attn point to the last line to see the same balls in
% the Chicago dialect: lacquer instead of metal.)

#include "lib/surfaces.ins"
#include "lib/build.ins"

[ 1.0 0.76 0.3 point     % gold
  0.98 0.5 0.33 point    % copper
  0.9 0.93 0.97 point    % silver
  0.35 0.6 1.0 point     % blued steel
  1.0 0.3 0.38 point     % anodised
  0.4 0.9 0.5 point ] /metals

% i ball -> object: on a ring of six
{ /i
  metals i get 0.12 0.88 90.0 plain apply sphere 0.8 uscale
  0.0 0.0 -1.75 translate i real 60.0 mulf 30.0 addf rotatey
} /ball

% The sky of a studio: a grid of soft boxes
{ /v /u /face
  u 16.0 mulf frac 0.5 subf /a
  v 9.0 mulf frac 0.5 subf /b
  a a mulf a a mulf mulf b b mulf b b mulf mulf addf 0.018 lessf { v 0.68 lessf } { true } if
    { 0.05 v 0.12 mulf addf /k  k k k point }
    { 1.1 1.1 1.1 point }
  if
  2.0 0.0 1.0
} /studio

6 ball repeat apply
1.0 1.0 1.0 point 0.05 0.9 90.0 plain apply sphere 0.55 uscale 0.0 -0.25 0.0 translate union
0.88 0.88 0.88 point 0.08 0.08 0.08 point 0.12 checker apply plane
  0.5 uscale
  0.1 0.1 0.1 point matte apply cylinder 3.6 1.0 3.6 scale 0.0 -0.9 0.0 translate intersect
  0.0 -0.8 0.0 translate union                  % a disc cut from the chequered plane
-27.0 rotatex 0.0 0.1 5.2 translate
studio 80.0 dome apply union /set

0.5 0.5 0.5 point
[ -4.0 6.0 -1.0 point  1.2 1.2 1.2 point  pointlight
   4.0 5.0 0.0 point  0.7 0.7 0.7 point  pointlight ]
set 5 50.0 320 240 "icfp-tint.ppm" render
