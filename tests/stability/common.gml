% Surfaces and pictures that the scenes of the stability suite share.

{ /color { /v /u /face color 1.0 0.0 1.0 } } /matte
{ /color { /v /u /face color 0.0 1.0 1.0 } } /mirror
{ /v /u /face
  u 8.0 mulf floor v 8.0 mulf floor addi 2 modi 0 eqi
  { 1.0 0.8 0.2 point } { 0.2 0.2 0.5 point } if 1.0 0.0 1.0
} /checkers

1.0 1.0 1.0 point /white
0.9 0.6 0.3 point /orange
0.2 0.5 0.9 point /blue
0.3 0.8 0.4 point /green
0.0 0.0 0.0 point /none

% OBJECT FOV WIDTH HEIGHT NAME flat: lit from everywhere, so that each surface shows its colour.
{ /name /height /width /fov /object
  white [ ] 1.0 0.0 0.0 point object 1 fov width height name render
} /flat

% OBJECT NAME sunny: in the light of a sun high on the left, 48 x 48 pixels.
[ 1.0 -1.0 1.0 point white light ] /sun
{ /name /object
  0.2 0.2 0.2 point sun 1.0 0.0 0.0 point object 1 60.0 48 48 name render
} /sunny

% LIGHTS AMBIENT OBJECT NAME lit: in these lights, which do not fade, 49 x 49 pixels at 90 degrees.
{ /name /object /ambient /lights
  ambient lights 1.0 0.0 0.0 point object 1 90.0 49 49 name render
} /lit
