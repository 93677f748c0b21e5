//! The window: events of the mouse, the keyboard and scripts go to its content, and what this draws is presented.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{Pos2, Rect, ViewportId};
use egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor};
use relievo_core::{Error, ErrorKind, Result};
use relievo_gpu::{Buffer, Device, wgpu};
use relievo_render::Image;
use relievo_render::color::decode_srgb;
use winit::application::ApplicationHandler;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::window::{Window, WindowId};

use crate::pen::{PenState, Pens};
use crate::player::{Player, Wish};
use crate::script::Script;

/// Points of the window at first.
const SIZE: [f64; 2] = [1440.0, 860.0];

/// Opens a window and returns its content when it is closed. A script acts first; the window closes at its end.
///
/// Fails if there is no display, if the graphics device cannot present to it, or if an act of the script finds no widget.
pub(crate) fn run<C: Content>(context: egui::Context, content: C, script: Option<Script>) -> Result<C> {
    let events = EventLoop::new().map_err(|error| {
        Error::new(ErrorKind::Device, format!("no window can be opened: {error}"))
            .advise(format!("run it on a desktop with X11, or use {}, which need no display", C::without_window()))
    })?;
    if script.is_some() {
        // A click stays one however long a frame takes.
        context.options_mut(|options| options.input_options.max_click_duration = f64::INFINITY);
    }
    let mut application =
        Application { content, context, player: script.map(Player::new), shown: None, began: None, outcome: Ok(()) };
    let ended = events.run_app(&mut application);
    application.outcome?;
    ended.map_err(|error| Error::new(ErrorKind::Device, format!("the window failed: {error}")))?;
    Ok(application.content)
}

/// What a window shows, and what scripts ask of it.
pub(crate) trait Content {
    /// The title of the window.
    fn title(&self) -> String;

    /// The commands that need no display, as advice where no window can be opened.
    fn without_window() -> &'static str;

    /// The device that draws.
    fn device(&self) -> &Device;

    /// Takes how the pen, or the mouse, was held since the last frame, in the order of its places.
    fn hold(&mut self, _pen: Vec<PenState>) {}

    /// Notes that a frame is drawn; `since` is how long ago the last one began that called for it at once, if there is one.
    fn count(&mut self, _since: Option<Duration>) {}

    /// Lays out a frame and acts on what the user does.
    fn show(&mut self, ui: &mut egui::Ui);

    /// Records what is drawn below the panels, into the whole of the target.
    ///
    /// # Errors
    /// The device has no memory for it, or is lost.
    fn draw(&mut self, encoder: &mut wgpu::CommandEncoder, target: &Target<'_>) -> Result<()> {
        let _pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(attachment(target.view, wgpu::LoadOp::Clear(wgpu::Color::BLACK)))],
            ..Default::default()
        });
        Ok(())
    }

    /// Notes that a person or a script asks the window to close, which unsaved work may refuse.
    fn close(&mut self);

    /// Whether the window is to close.
    fn closes(&self) -> bool;

    /// Shows a fault of the window.
    fn say(&mut self, message: String);

    /// Writes beside its files what was not saved. Returns where, if there was anything.
    ///
    /// # Errors
    /// It cannot be written.
    fn rescue(&mut self) -> Result<Option<PathBuf>>;

    /// Keeps what is to be there at the next start, when the window closes.
    ///
    /// # Errors
    /// It cannot be written.
    fn end(&mut self) -> Result<()> {
        Ok(())
    }

    /// Whether all pictures are there that come some time after what asks for them.
    fn is_resting(&self) -> bool {
        true
    }

    /// Returns the area, in points, whose picture is to be recorded without panels in this frame.
    fn recorded(&mut self) -> Option<Rect> {
        None
    }

    /// Takes the picture of that area.
    ///
    /// # Errors
    /// It cannot be written.
    fn record(&mut self, _picture: Image) -> Result<()> {
        Ok(())
    }

    /// Returns where the widget of a name was drawn last, in points.
    fn widget(&self, name: &str) -> Option<Rect>;

    /// Returns the middle of a pixel of the picture, in points.
    fn pixel(&self, _pixel: [u32; 2]) -> Option<Pos2> {
        None
    }

    /// Returns where the plot of two features was drawn last, in points.
    fn plot(&self, _axes: [usize; 2]) -> Option<Rect> {
        None
    }

    /// Returns where the view of a model was drawn last, in points.
    fn view(&self) -> Option<Rect> {
        None
    }

    /// Takes the text of a file in place of the one that is edited.
    ///
    /// # Errors
    /// There is no text to edit, or the file cannot be read.
    fn replace_text(&mut self, file: &Path) -> Result<()> {
        Err(Error::invalid("this window has no text").at(file.display().to_string()))
    }
}

/// What a frame is drawn into.
pub(crate) struct Target<'a> {
    pub view: &'a wgpu::TextureView,
    pub format: wgpu::TextureFormat,
    /// Pixels.
    pub size: [u32; 2],
    /// Pixels of a point.
    pub scale: f32,
}

/// Describes a target of colour of a pass.
pub(crate) fn attachment(
    view: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) -> wgpu::RenderPassColorAttachment<'_> {
    let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
    wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops }
}

/// What is there while the window is open.
struct Shown {
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    configuration: wgpu::SurfaceConfiguration,
    input: egui_winit::State,
    renderer: Renderer,
    pens: Option<Pens>,
}

struct Application<C> {
    content: C,
    context: egui::Context,
    player: Option<Player>,
    shown: Option<Shown>,
    /// When the last frame began, if it called for the next at once.
    began: Option<Instant>,
    outcome: Result<()>,
}

impl<C: Content> Application<C> {
    fn open(&self, events: &ActiveEventLoop) -> Result<Shown> {
        let failed = |error: String| Error::new(ErrorKind::Device, format!("the window cannot be opened: {error}"));
        let size = winit::dpi::LogicalSize::new(SIZE[0], SIZE[1]);
        let attributes = Window::default_attributes().with_title(self.content.title()).with_inner_size(size);
        let window = Arc::new(events.create_window(attributes).map_err(|error| failed(error.to_string()))?);
        let size = window.inner_size();
        let device = self.content.device();
        let target = wgpu::SurfaceTarget::DisplayAndWindow(Box::new(Arc::clone(&window)));
        let (surface, configuration) = device.surface(target, [size.width.max(1), size.height.max(1)])?;
        device.guard(|| surface.configure(device.wgpu(), &configuration))?;
        let renderer =
            device.guard(|| Renderer::new(device.wgpu(), configuration.format, RendererOptions::PREDICTABLE))?;
        let most = device.limits().max_texture_dimension_2d as usize;
        let scale = window.scale_factor() as f32;
        let input =
            egui_winit::State::new(self.context.clone(), ViewportId::ROOT, &window, Some(scale), None, Some(most));
        Ok(Shown { window, surface, configuration, input, renderer, pens: Pens::open() })
    }

    /// Draws a frame as [`Self::frame`] does, and has the content count it.
    fn timed_frame(&mut self) -> Result<Option<Duration>> {
        let begins = Instant::now();
        let delay = self.frame()?;
        self.content.count(self.began.map(|before| begins - before));
        self.began = (delay == Some(Duration::ZERO)).then_some(begins);
        Ok(delay)
    }

    /// Draws a frame. Returns how long nothing changes without an event, or `None` once the window is to close.
    fn frame(&mut self) -> Result<Option<Duration>> {
        let Self { content, context, player, shown, .. } = self;
        let Some(shown) = shown else { return Ok(Some(Duration::MAX)) };
        let mut input = shown.input.take_egui_input(&shown.window);
        let mut wish = Wish::Nothing;
        let held = shown.pens.as_mut().map_or_else(Vec::new, Pens::take);
        content.hold(player.as_ref().map_or(held, |player| vec![player.pen]));
        if let Some(player) = player {
            let (events, wished) = player.step(content)?;
            // A script has the focus that a person would give by a click.
            input.focused = true;
            input.events.extend(events);
            wish = wished;
        }
        let output = context.run_ui(input, |ui| content.show(ui));
        shown.input.handle_platform_output(&shown.window, output.platform_output);
        let meshes = context.tessellate(output.shapes, output.pixels_per_point);
        shown.paint(content, &meshes, &output.textures_delta, output.pixels_per_point)?;
        if let Wish::Screenshot(file) = &wish {
            let picture = shown.picture(content, &meshes, output.pixels_per_point)?;
            relievo_render::write_png(file, &picture)?;
        }
        if let Some(area) = content.recorded() {
            let picture = shown.picture(content, &[], output.pixels_per_point)?;
            content.record(part(&picture, area, output.pixels_per_point)?)?;
        }
        for texture in &output.textures_delta.free {
            shown.renderer.free_texture(texture);
        }
        if let Wish::Resize([width, height]) = wish {
            // What is granted at once is not told by an event.
            if let Some(size) = shown.window.request_inner_size(winit::dpi::PhysicalSize::new(width, height)) {
                shown.resize(content.device(), size)?;
            }
        }
        if let Wish::Drop(file) = &wish {
            let _response = shown.input.on_window_event(&shown.window, &WindowEvent::DroppedFile(file.clone()));
        }
        if content.closes() || matches!(wish, Wish::End) {
            content.end()?;
            return Ok(None);
        }
        let delay = output.viewport_output.get(&ViewportId::ROOT).map_or(Duration::MAX, |it| it.repaint_delay);
        Ok(Some(if player.is_some() { Duration::ZERO } else { delay }))
    }
}

impl Shown {
    /// Takes on another size in pixels.
    fn resize(&mut self, device: &Device, size: winit::dpi::PhysicalSize<u32>) -> Result<()> {
        if size.width == 0 || size.height == 0 {
            return Ok(());
        }
        (self.configuration.width, self.configuration.height) = (size.width, size.height);
        device.guard(|| self.surface.configure(device.wgpu(), &self.configuration))
    }

    fn paint(
        &mut self,
        content: &mut impl Content,
        meshes: &[egui::ClippedPrimitive],
        textures: &egui::TexturesDelta,
        scale: f32,
    ) -> Result<()> {
        let device = &content.device().clone();
        for (id, delta) in textures.set.iter().flat_map(|(id, deltas)| deltas.iter().map(move |delta| (id, delta))) {
            device.guard(|| self.renderer.update_texture(device.wgpu(), device.queue(), *id, delta))?;
        }
        use wgpu::CurrentSurfaceTexture::{Lost, Outdated, Suboptimal, Success};
        let texture = match device.guard(|| self.surface.get_current_texture())? {
            Success(texture) | Suboptimal(texture) => texture,
            Outdated | Lost => return device.guard(|| self.surface.configure(device.wgpu(), &self.configuration)),
            // A window that is hidden or busy is drawn when it is asked for again.
            _ => return Ok(()),
        };
        let mut frame = device.frame()?;
        let view = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
        self.record(content, frame.encoder(), &view, meshes, scale)?;
        let _submitted = frame.submit()?;
        device.guard(|| device.queue().present(texture))
    }

    fn record(
        &mut self,
        content: &mut impl Content,
        encoder: &mut wgpu::CommandEncoder,
        view: &wgpu::TextureView,
        meshes: &[egui::ClippedPrimitive],
        scale: f32,
    ) -> Result<()> {
        let size = [self.configuration.width, self.configuration.height];
        content.draw(encoder, &Target { view, format: self.configuration.format, size, scale })?;
        let device = content.device();
        let screen = ScreenDescriptor { size_in_pixels: size, pixels_per_point: scale };
        self.renderer.update_buffers(device.wgpu(), device.queue(), encoder, meshes, &screen);
        let color_attachments = &[Some(attachment(view, wgpu::LoadOp::Load))];
        let descriptor = wgpu::RenderPassDescriptor { color_attachments, ..Default::default() };
        let mut pass = encoder.begin_render_pass(&descriptor).forget_lifetime();
        self.renderer.render(&mut pass, meshes, &screen);
        Ok(())
    }

    /// Draws the frame once more and returns the picture of it.
    fn picture(&mut self, content: &mut impl Content, meshes: &[egui::ClippedPrimitive], scale: f32) -> Result<Image> {
        let device = &content.device().clone();
        let [width, height] = [self.configuration.width, self.configuration.height];
        let extent = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let row = width.next_multiple_of(64);
        let buffer = Buffer::<u32>::new(device, "screenshot", row as usize * height as usize)?;
        let texture = device.guard(|| {
            device.wgpu().create_texture(&wgpu::TextureDescriptor {
                label: Some("screenshot"),
                size: extent,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: self.configuration.format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            })
        })?;
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut frame = device.frame()?;
        self.record(content, frame.encoder(), &view, meshes, scale)?;
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * row), rows_per_image: Some(height) };
        let target = wgpu::TexelCopyBufferInfo { buffer: buffer.wgpu(), layout };
        frame.encoder().copy_texture_to_buffer(texture.as_image_copy(), target, extent);
        let read = frame.read(&buffer, 0..buffer.len())?;
        let _submitted = frame.submit()?;
        let words = read.get(device)?;
        let is_blue_first = self.configuration.format == wgpu::TextureFormat::Bgra8Unorm;
        let order = if is_blue_first { [2, 1, 0] } else { [0, 1, 2] };
        let pixels = words.chunks_exact(row as usize).flat_map(|line| &line[..width as usize]);
        let data = pixels.flat_map(|word| {
            let bytes = word.to_le_bytes();
            order.map(|channel| decode_srgb(f32::from(bytes[channel]) / 255.0))
        });
        Image::from_data(width, height, 3, data.collect())
    }
}

/// Returns the part of a picture of the window that an area in points has.
fn part(picture: &Image, area: Rect, scale: f32) -> Result<Image> {
    let pixel = |at: f32, most: u32| ((at * scale).round().max(0.0) as u32).min(most);
    let [left, right] = [area.left(), area.right()].map(|at| pixel(at, picture.width()));
    let [top, bottom] = [area.top(), area.bottom()].map(|at| pixel(at, picture.height()));
    let mut made = Image::new(right.saturating_sub(left), bottom.saturating_sub(top), 3)?;
    for (x, y) in (0..made.height()).flat_map(|y| (0..right - left).map(move |x| (x, y))) {
        made.set_color(x, y, picture.color(left + x, top + y));
    }
    Ok(made)
}

impl<C: Content> ApplicationHandler for Application<C> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.shown.is_some() {
            return;
        }
        match self.open(events) {
            Ok(shown) => {
                shown.window.request_redraw();
                self.shown = Some(shown);
            }
            Err(error) => {
                self.outcome = Err(error);
                events.exit();
            }
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(shown) = &mut self.shown else { return };
        let response = shown.input.on_window_event(&shown.window, &event);
        if response.repaint {
            shown.window.request_redraw();
        }
        match event {
            WindowEvent::CloseRequested => {
                self.content.close();
                shown.window.request_redraw();
            }
            WindowEvent::Resized(size) => {
                if let Err(error) = shown.resize(self.content.device(), size) {
                    self.content.say(error.to_string());
                }
                shown.window.request_redraw();
            }
            WindowEvent::RedrawRequested => match self.timed_frame() {
                Ok(None) => events.exit(),
                Ok(Some(Duration::ZERO)) => {
                    if let Some(shown) = &self.shown {
                        shown.window.request_redraw();
                    }
                }
                Ok(Some(delay)) => events.set_control_flow(match Instant::now().checked_add(delay) {
                    Some(until) => ControlFlow::WaitUntil(until),
                    None => ControlFlow::Wait,
                }),
                Err(error) => {
                    let error = match self.content.rescue() {
                        Ok(None) => error,
                        Ok(Some(path)) => error.advise(format!("what was not saved is in {}", path.display())),
                        Err(second) => error.advise(format!("what was not saved is lost: {second}")),
                    };
                    self.outcome = Err(error);
                    events.exit();
                }
            },
            _ => {}
        }
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: winit::event::StartCause) {
        if matches!(cause, winit::event::StartCause::ResumeTimeReached { .. })
            && let Some(shown) = &self.shown
        {
            shown.window.request_redraw();
        }
    }
}
