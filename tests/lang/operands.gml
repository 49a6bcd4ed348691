% Every operator finds too few operands, and each operand of the wrong type. The place is the operator's.

% One operand less than it takes: the one outside the array is out of reach.
5 [ negi ] %! error E0101 at 5
5 [ negf ] %! error E0101 at 5
5 [ floor ] %! error E0101 at 5
5 [ frac ] %! error E0101 at 5
5 [ real ] %! error E0101 at 5
5 [ clampf ] %! error E0101 at 5
5 [ sqrt ] %! error E0101 at 5
5 [ sin ] %! error E0101 at 5
5 [ cos ] %! error E0101 at 5
5 [ asin ] %! error E0101 at 5
5 [ acos ] %! error E0101 at 5
5 [ getx ] %! error E0101 at 5
5 [ gety ] %! error E0101 at 5
5 [ getz ] %! error E0101 at 5
5 [ 1 addi ] %! error E0101 at 7
5 [ 0.5 addf ] %! error E0101 at 9
5 [ 1 subi ] %! error E0101 at 7
5 [ 0.5 subf ] %! error E0101 at 9
5 [ 1 muli ] %! error E0101 at 7
5 [ 0.5 mulf ] %! error E0101 at 9
5 [ 1 divi ] %! error E0101 at 7
5 [ 0.5 divf ] %! error E0101 at 9
5 [ 1 modi ] %! error E0101 at 7
5 [ 1 eqi ] %! error E0101 at 7
5 [ 0.5 eqf ] %! error E0101 at 9
5 [ 1 lessi ] %! error E0101 at 7
5 [ 0.5 lessf ] %! error E0101 at 9
5 [ 0.5 0.5 point ] %! error E0101 at 13
5 [ apply ] %! error E0101 at 5
5 [ { } { } if ] %! error E0101 at 13
5 [ 1 get ] %! error E0101 at 7
5 [ length ] %! error E0101 at 5
5 [ sphere ] %! error E0101 at 5
5 [ cube ] %! error E0101 at 5
5 [ cylinder ] %! error E0101 at 5
5 [ cone ] %! error E0101 at 5
5 [ plane ] %! error E0101 at 5
5 [ 0.5 0.5 0.5 translate ] %! error E0101 at 17
5 [ 0.5 0.5 0.5 scale ] %! error E0101 at 17
5 [ 0.5 uscale ] %! error E0101 at 9
5 [ 0.5 rotatex ] %! error E0101 at 9
5 [ 0.5 rotatey ] %! error E0101 at 9
5 [ 0.5 rotatez ] %! error E0101 at 9
5 [ 0.0 0.0 0.0 point light ] %! error E0101 at 23
5 [ 0.0 0.0 0.0 point pointlight ] %! error E0101 at 23
5 [ 0.0 0.0 0.0 point 0.0 0.0 0.0 point 0.5 0.5 spotlight ] %! error E0101 at 49
5 [ { } sphere union ] %! error E0101 at 16
5 [ { } sphere intersect ] %! error E0101 at 16
5 [ { } sphere difference ] %! error E0101 at 16
5 [ [ 7 8 ] { } sphere 1 0.5 1 1 "s" render ] %! error E0101 at 38

% One operand of the wrong type.
1.0 negi %! error E0201 at 5
1 negf %! error E0201 at 3
1 floor %! error E0201 at 3
1 frac %! error E0201 at 3
1.0 real %! error E0201 at 5
1 clampf %! error E0201 at 3
1 sqrt %! error E0201 at 3
1 sin %! error E0201 at 3
1 cos %! error E0201 at 3
1 asin %! error E0201 at 3
1 acos %! error E0201 at 3
0.0 getx %! error E0201 at 5
0.0 gety %! error E0201 at 5
0.0 getz %! error E0201 at 5
1.0 1 addi %! error E0201 at 7
1 1.0 addi %! error E0201 at 7
1 0.5 addf %! error E0201 at 7
0.5 1 addf %! error E0201 at 7
1.0 1 subi %! error E0201 at 7
1 1.0 subi %! error E0201 at 7
1 0.5 subf %! error E0201 at 7
0.5 1 subf %! error E0201 at 7
1.0 1 muli %! error E0201 at 7
1 1.0 muli %! error E0201 at 7
1 0.5 mulf %! error E0201 at 7
0.5 1 mulf %! error E0201 at 7
1.0 1 divi %! error E0201 at 7
1 1.0 divi %! error E0201 at 7
1 0.5 divf %! error E0201 at 7
0.5 1 divf %! error E0201 at 7
1.0 1 modi %! error E0201 at 7
1 1.0 modi %! error E0201 at 7
1.0 1 eqi %! error E0201 at 7
1 1.0 eqi %! error E0201 at 7
1 0.5 eqf %! error E0201 at 7
0.5 1 eqf %! error E0201 at 7
1.0 1 lessi %! error E0201 at 7
1 1.0 lessi %! error E0201 at 7
1 0.5 lessf %! error E0201 at 7
0.5 1 lessf %! error E0201 at 7
1 0.5 0.5 point %! error E0201 at 11
0.5 1 0.5 point %! error E0201 at 11
0.5 0.5 1 point %! error E0201 at 11
[ ] apply %! error E0201 at 5
0 { } { } if %! error E0201 at 11
true [ ] { } if %! error E0201 at 14
true { } [ ] if %! error E0201 at 14
{ } 1 get %! error E0201 at 7
[ 7 8 ] 1.0 get %! error E0201 at 13
{ } length %! error E0201 at 5
[ ] sphere %! error E0201 at 5
[ ] cube %! error E0201 at 5
[ ] cylinder %! error E0201 at 5
[ ] cone %! error E0201 at 5
[ ] plane %! error E0201 at 5
{ } 0.5 0.5 0.5 translate %! error E0201 at 17
{ } sphere 1 0.5 0.5 translate %! error E0201 at 22
{ } sphere 0.5 1 0.5 translate %! error E0201 at 22
{ } sphere 0.5 0.5 1 translate %! error E0201 at 22
{ } 0.5 0.5 0.5 scale %! error E0201 at 17
{ } sphere 1 0.5 0.5 scale %! error E0201 at 22
{ } sphere 0.5 1 0.5 scale %! error E0201 at 22
{ } sphere 0.5 0.5 1 scale %! error E0201 at 22
{ } 0.5 uscale %! error E0201 at 9
{ } sphere 1 uscale %! error E0201 at 14
{ } 0.5 rotatex %! error E0201 at 9
{ } sphere 1 rotatex %! error E0201 at 14
{ } 0.5 rotatey %! error E0201 at 9
{ } sphere 1 rotatey %! error E0201 at 14
{ } 0.5 rotatez %! error E0201 at 9
{ } sphere 1 rotatez %! error E0201 at 14
0.0 0.0 0.0 0.0 point light %! error E0201 at 23
0.0 0.0 0.0 point 0.0 light %! error E0201 at 23
0.0 0.0 0.0 0.0 point pointlight %! error E0201 at 23
0.0 0.0 0.0 point 0.0 pointlight %! error E0201 at 23
0.0 0.0 0.0 0.0 point 0.0 0.0 0.0 point 0.5 0.5 spotlight %! error E0201 at 49
0.0 0.0 0.0 point 0.0 0.0 0.0 0.0 point 0.5 0.5 spotlight %! error E0201 at 49
0.0 0.0 0.0 point 0.0 0.0 0.0 point 0.0 0.5 0.5 spotlight %! error E0201 at 49
0.0 0.0 0.0 point 0.0 0.0 0.0 point 0.0 0.0 0.0 point 1 0.5 spotlight %! error E0201 at 61
0.0 0.0 0.0 point 0.0 0.0 0.0 point 0.0 0.0 0.0 point 0.5 1 spotlight %! error E0201 at 61
{ } { } sphere union %! error E0201 at 16
{ } sphere { } union %! error E0201 at 16
{ } { } sphere intersect %! error E0201 at 16
{ } sphere { } intersect %! error E0201 at 16
{ } { } sphere difference %! error E0201 at 16
{ } sphere { } difference %! error E0201 at 16
0.0 [ 7 8 ] { } sphere 1 0.5 1 1 "s" render %! error E0201 at 38
0.0 0.0 0.0 point { } { } sphere 1 0.5 1 1 "s" render %! error E0201 at 48
0.0 0.0 0.0 point [ 7 8 ] { } 1 0.5 1 1 "s" render %! error E0201 at 45
0.0 0.0 0.0 point [ 7 8 ] { } sphere 1.0 0.5 1 1 "s" render %! error E0201 at 54
0.0 0.0 0.0 point [ 7 8 ] { } sphere 1 1 1 1 "s" render %! error E0201 at 50
0.0 0.0 0.0 point [ 7 8 ] { } sphere 1 0.5 1.0 1 "s" render %! error E0201 at 54
0.0 0.0 0.0 point [ 7 8 ] { } sphere 1 0.5 1 1.0 "s" render %! error E0201 at 54
0.0 0.0 0.0 point [ 7 8 ] { } sphere 1 0.5 1 1 1 render %! error E0201 at 50
