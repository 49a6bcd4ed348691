//! A backend that draws all of it twice as large: what is laid out for screens of old is sharp on
//! those of today.

use plotters::style::{FontDesc, ShapeStyle, TextStyle};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};

/// Pixels of the inner backend for one of the drawing, along each side.
pub(super) const FACTOR: u32 = 2;

/// The backend that gets the larger drawing.
pub(super) struct Doubled<B>(pub(super) B);

type Done<B> = Result<(), DrawingErrorKind<<B as DrawingBackend>::ErrorType>>;

fn doubled((x, y): BackendCoord) -> BackendCoord {
    let factor = FACTOR as i32;
    (factor * x, factor * y)
}

fn doubled_style(style: &impl BackendStyle) -> ShapeStyle {
    let BackendColor { alpha, rgb: (r, g, b) } = style.color();
    let color = plotters::style::RGBAColor(r, g, b, alpha);
    ShapeStyle { color, filled: false, stroke_width: FACTOR * style.stroke_width() }
}

impl<B: DrawingBackend> DrawingBackend for Doubled<B> {
    type ErrorType = B::ErrorType;

    fn get_size(&self) -> (u32, u32) {
        let (width, height) = self.0.get_size();
        (width / FACTOR, height / FACTOR)
    }

    fn ensure_prepared(&mut self) -> Done<B> {
        self.0.ensure_prepared()
    }

    fn present(&mut self) -> Done<B> {
        self.0.present()
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Done<B> {
        self.draw_rect((x, y), (x + 1, y + 1), &color, true)
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Done<B> {
        self.0.draw_line(doubled(from), doubled(to), &doubled_style(style))
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        upper_left: BackendCoord,
        lower_right: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Done<B> {
        self.0.draw_rect(doubled(upper_left), doubled(lower_right), &doubled_style(style), fill)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Done<B> {
        self.0.draw_path(path.into_iter().map(doubled), &doubled_style(style))
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        center: BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Done<B> {
        self.0.draw_circle(doubled(center), FACTOR * radius, &doubled_style(style), fill)
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        corners: I,
        style: &S,
    ) -> Done<B> {
        self.0.fill_polygon(corners.into_iter().map(doubled), &doubled_style(style))
    }

    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        place: BackendCoord,
    ) -> Done<B> {
        let font = FontDesc::new(style.family(), f64::from(FACTOR) * style.size(), style.style())
            .transform(style.transform());
        let style = TextStyle { font, color: style.color(), pos: style.anchor() };
        self.0.draw_text(text, &style, doubled(place))
    }
}
