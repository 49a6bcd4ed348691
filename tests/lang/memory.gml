% One program a line, and behind `%!` the stack it leaves, or `error CODE at COLUMN`.
% Loops that make far more than they keep: 256 MiB would not hold it.
{ /self /n n 0 eqi { 0 } { [ n n n n n n n n n n ] length /k n 1 subi self self apply } if } /arrays 2000000 arrays arrays apply %! 0
{ /self /n n 0 eqi { 0 } { n /k { n k } /f f apply addi /both n 1 subi self self apply } if } /closures 2000000 closures closures apply %! 0
{ /v /u /face 0.1 0.2 0.3 point 1.0 0.0 1.0 } /plain { /self /n n 0 eqi { 0 } { plain sphere 2.0 uscale plain cube union /solid n 1 subi self self apply } if } /solids 1000000 solids solids apply %! 0
{ /self /n n 0 eqi { 0 } { { /v /u /face n real u v point 1.0 0.0 1.0 } sphere /solid n 1 subi self self apply } if } /surfaces 500000 surfaces surfaces apply %! 0
% What is carried from round to round, held by callers, or lies in an open array, stays.
{ /self /state /n n 0 eqi { state 0 get state 1 get } { [ n n n n n n n n ] /waste n 1 subi [ state 0 get 1 addi n ] self self apply } if } /carry 100000 [ 5 0 ] carry carry apply %! 100005 1
{ /self /f /n n 0 eqi { 1 f apply } { [ n n n n n n n n ] /waste n 1 subi { 1 addi f apply } self self apply } if } /wrap 20000 { 7 muli } wrap wrap apply %! 140007
{ /self /n n 0 eqi { 0 } { [ n n n n n n n n n n ] /waste n 1 subi self self apply } if } /burn 7 /seven [ 1 [ 2 seven ] { seven } 50000 burn burn apply /zero 6 [ seven ] ] /held 50000 burn burn apply held 1 get 1 get held 2 get apply held 3 get held 4 get 0 get %! 0 7 7 6 7
{ /self /n n 0 eqi { 0 } { [ n n n n n n n n n n ] /waste n 1 subi self self apply } if } /burn { /self /n n 0 eqi { 0 } { [ n ] /mine { n 2 muli } /twice 3000 burn burn apply /zero n 1 subi self self apply mine 0 get addi twice apply addi } if } /tower 40 tower tower apply %! 2460
{ /self /n n 0 eqi { 0 } { [ n n n n n n n n n n ] /waste n 1 subi self self apply } if } /burn { /v /u /face 0.5 0.5 0.5 point 1.0 0.0 1.0 } sphere /solid 30000 burn burn apply solid solid union /both 30000 burn burn apply %! 0 0
{ /self /list /n n 0 eqi { list } { n 1 subi [ n list ] self self apply } if } /build { /self /sum /list list length 0 eqi { sum } { list 1 get sum list 0 get addi self self apply } if } /total 30000 [ ] build build apply 0 total total apply %! 450015000
{ /self /n n 0 eqi { 0 } { [ n n n n n n n n n n ] /waste n 1 subi self self apply } if } /burn { /x [ x x ] /pair { pair 0 get x addi } /sum 30000 burn burn apply sum apply addi pair 1 get } /keeps 1 keeps apply 20 keeps apply %! 2 1 40 20
{ /n [ n n n n n n n n n n ] /waste n 0 eqi { 0 } { n 1 subi } if } /less { /self /n { /m [ m n m n m n m n ] /waste m n addi } /fresh n 0 eqi { 0 fresh apply } { n less apply self self apply } if } /mutual 20000 mutual mutual apply %! 0
{ /self /list /n n 0 eqi { list } { n 1 subi [ n list ] self self apply } if } /build { /n n [ ] build build apply /list { /x list 1 get 0 get x addi [ x x x ] length addi } /fresh 5 fresh apply } /last 4000 last apply %! 10
