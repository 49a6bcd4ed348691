% An eye inside a cube: the room that it encloses, with a pillar that is cut out of it.
{ /v /u /face u v face real 5.0 divf point 0.8 0.0 1.0 } cube -0.5 -0.5 -0.5 translate 4.0 uscale
{ /v /u /face 0.9 0.9 0.9 point 0.8 0.3 8.0 } cylinder 0.3 9.0 0.3 scale 0.3 -4.5 0.9 translate difference /scene
-1.0 1.0 0.0 point 1.0 1.0 1.0 point pointlight /lamp
0.2 0.2 0.2 point [ lamp ] scene 2 90.0 64 48 "inside.ppm" render
