% Nine colours in a table, picked by which third of the face u and v fall in.
0.9 0.8 0.6 point /light-tile
0.2 0.1 0.1 point /dark-tile
[ [ light-tile dark-tile light-tile ]
  [ dark-tile light-tile dark-tile ]
  [ light-tile dark-tile light-tile ] ] /tiles
{ /v /u /face
  tiles v 3.0 mulf floor get u 3.0 mulf floor get
  0.8 0.2 6.0 }
