//! The window: events of the mouse, the keyboard and scripts go to the panels, and what these draw is presented.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{Event, Modifiers, PointerButton, Pos2, Rect, ViewportId, pos2};
use egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor};
use relievo_core::{Error, ErrorKind, Result};
use relievo_gpu::{Buffer, wgpu};
use relievo_render::Image;
use relievo_render::color::decode_srgb;
use winit::application::ApplicationHandler;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::window::{Window, WindowId};

use crate::panels::Panels;
use crate::script::{Act, Script};
use crate::session::Session;

/// Points of the window at first.
const SIZE: [f64; 2] = [1440.0, 860.0];

/// Frames that a script waits for a widget that is not there yet.
const PATIENCE: u32 = 120;

/// Opens the window of a session and returns when it is closed. A script acts first; the window closes at its end.
///
/// Fails if there is no display, if the graphics device cannot present to it, or if an act of the script finds no widget.
pub fn run(session: Session, script: Option<Script>) -> Result<()> {
    let events = EventLoop::new().map_err(|error| {
        Error::new(ErrorKind::Device, format!("no window can be opened: {error}"))
            .advise("run it on a desktop with X11, or use `relievo shader run` and `classify`, which need no display")
    })?;
    let mut application = Application {
        session,
        context: egui::Context::default(),
        player: script.map(Player::new),
        shown: None,
        outcome: Ok(()),
    };
    let ended = events.run_app(&mut application);
    application.outcome?;
    ended.map_err(|error| Error::new(ErrorKind::Device, format!("the window failed: {error}")))
}

/// A script that is played.
struct Player {
    acts: VecDeque<Act>,
    /// Events of the next frames.
    frames: VecDeque<Vec<Event>>,
    waited: u32,
}

/// What a frame of a script asks for besides events.
enum Wish {
    Nothing,
    Screenshot(std::path::PathBuf),
    End,
}

impl Player {
    fn new(script: Script) -> Self {
        Self { acts: script.acts.into(), frames: VecDeque::new(), waited: 0 }
    }

    /// Returns the events of the next frame.
    fn step(&mut self, panels: &mut Panels, session: &mut Session) -> Result<(Vec<Event>, Wish)> {
        if let Some(events) = self.frames.pop_front() {
            return Ok((events, Wish::Nothing));
        }
        let Some(act) = self.acts.front().cloned() else { return Ok((Vec::new(), Wish::End)) };
        let frames = match &act {
            Act::Click { pixel, button } => panels.place(*pixel, session.size()).map(|at| click(at, *button)),
            Act::Press(name) => panels.widget(name).map(|area| click(area.center(), PointerButton::Primary)),
            Act::Drag { axes, from, to } => panels.plot(*axes).map(|area| drag(area, *from, *to)),
            Act::Key { key, has_control } => {
                let modifiers = if *has_control { Modifiers::CTRL | Modifiers::COMMAND } else { Modifiers::NONE };
                let event =
                    |pressed| vec![Event::Key { key: *key, physical_key: None, pressed, repeat: false, modifiers }];
                Some(vec![event(true), event(false)])
            }
            Act::Type(text) => Some(vec![vec![Event::Text(text.clone())]]),
            Act::Text(file) => {
                session.text = relievo_shaderlab::Source::read(file)?.text.to_string();
                panels.text_changed();
                Some(vec![Vec::new(); 2])
            }
            Act::Wait(count) => Some(vec![Vec::new(); *count as usize]),
            Act::Screenshot(file) => {
                self.acts.pop_front();
                return Ok((Vec::new(), Wish::Screenshot(file.clone())));
            }
            Act::Quit => return Ok((Vec::new(), Wish::End)),
        };
        match frames {
            Some(frames) => {
                self.acts.pop_front();
                self.waited = 0;
                self.frames = frames.into();
                Ok((self.frames.pop_front().unwrap_or_default(), Wish::Nothing))
            }
            None if self.waited < PATIENCE => {
                self.waited += 1;
                Ok((Vec::new(), Wish::Nothing))
            }
            None => Err(Error::invalid(format!("the window shows nothing for {act:?}")).at("the script")),
        }
    }
}

fn button(at: Pos2, button: PointerButton, pressed: bool) -> Event {
    Event::PointerButton { pos: at, button, pressed, modifiers: Modifiers::NONE }
}

/// Returns frames in which the pointer moves to a place, presses a button and releases it.
fn click(at: Pos2, which: PointerButton) -> Vec<Vec<Event>> {
    vec![vec![Event::PointerMoved(at)], vec![button(at, which, true)], vec![button(at, which, false)], Vec::new()]
}

fn drag(area: Rect, from: [f32; 2], to: [f32; 2]) -> Vec<Vec<Event>> {
    let at = |[x, y]: [f32; 2]| pos2(area.left() + x * area.width(), area.top() + y * area.height());
    let (first, last) = (at(from), at(to));
    vec![
        vec![Event::PointerMoved(first)],
        vec![button(first, PointerButton::Primary, true)],
        vec![Event::PointerMoved(first.lerp(last, 0.5))],
        vec![Event::PointerMoved(last)],
        vec![button(last, PointerButton::Primary, false)],
        Vec::new(),
    ]
}

/// What is there while the window is open.
struct Shown {
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    configuration: wgpu::SurfaceConfiguration,
    input: egui_winit::State,
    renderer: Renderer,
    panels: Panels,
}

struct Application {
    session: Session,
    context: egui::Context,
    player: Option<Player>,
    shown: Option<Shown>,
    outcome: Result<()>,
}

impl Application {
    fn open(&self, events: &ActiveEventLoop) -> Result<Shown> {
        let failed = |error: String| Error::new(ErrorKind::Device, format!("the window cannot be opened: {error}"));
        let size = winit::dpi::LogicalSize::new(SIZE[0], SIZE[1]);
        let attributes = Window::default_attributes().with_title("Relievo: shaders").with_inner_size(size);
        let window = Arc::new(events.create_window(attributes).map_err(|error| failed(error.to_string()))?);
        let size = window.inner_size();
        let device = self.session.device();
        let target = wgpu::SurfaceTarget::DisplayAndWindow(Box::new(Arc::clone(&window)));
        let (surface, configuration) = device.surface(target, [size.width.max(1), size.height.max(1)])?;
        device.guard(|| surface.configure(device.wgpu(), &configuration))?;
        let renderer =
            device.guard(|| Renderer::new(device.wgpu(), configuration.format, RendererOptions::PREDICTABLE))?;
        let most = device.limits().max_texture_dimension_2d as usize;
        let scale = window.scale_factor() as f32;
        let input =
            egui_winit::State::new(self.context.clone(), ViewportId::ROOT, &window, Some(scale), None, Some(most));
        let panels = Panels::new(&self.context, &self.session);
        Ok(Shown { window, surface, configuration, input, renderer, panels })
    }

    /// Draws a frame. Returns how long nothing changes without an event, or `None` once the window is to close.
    fn frame(&mut self) -> Result<Option<Duration>> {
        let Self { session, context, player, shown, .. } = self;
        let Some(shown) = shown else { return Ok(Some(Duration::MAX)) };
        let mut input = shown.input.take_egui_input(&shown.window);
        let mut wish = Wish::Nothing;
        if let Some(player) = player {
            let (events, wished) = player.step(&mut shown.panels, session)?;
            // A script has the focus that a person would give by a click.
            input.focused = true;
            input.events.extend(events);
            wish = wished;
        }
        let output = context.run_ui(input, |ui| shown.panels.show(ui, session));
        shown.input.handle_platform_output(&shown.window, output.platform_output);
        let meshes = context.tessellate(output.shapes, output.pixels_per_point);
        shown.paint(session, &meshes, &output.textures_delta, output.pixels_per_point)?;
        if let Wish::Screenshot(file) = &wish {
            shown.screenshot(session, &meshes, output.pixels_per_point, file)?;
        }
        for texture in &output.textures_delta.free {
            shown.renderer.free_texture(texture);
        }
        if shown.panels.closes() || matches!(wish, Wish::End) {
            return Ok(None);
        }
        let delay = output.viewport_output.get(&ViewportId::ROOT).map_or(Duration::MAX, |it| it.repaint_delay);
        Ok(Some(if player.is_some() { Duration::ZERO } else { delay }))
    }
}

impl Shown {
    fn paint(
        &mut self,
        session: &Session,
        meshes: &[egui::ClippedPrimitive],
        textures: &egui::TexturesDelta,
        scale: f32,
    ) -> Result<()> {
        let device = session.device();
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
        self.record(session, frame.encoder(), &view, meshes, scale);
        let _submitted = frame.submit()?;
        device.guard(|| device.queue().present(texture))
    }

    fn record(
        &mut self,
        session: &Session,
        encoder: &mut wgpu::CommandEncoder,
        view: &wgpu::TextureView,
        meshes: &[egui::ClippedPrimitive],
        scale: f32,
    ) {
        let device = session.device();
        let size_in_pixels = [self.configuration.width, self.configuration.height];
        let screen = ScreenDescriptor { size_in_pixels, pixels_per_point: scale };
        self.renderer.update_buffers(device.wgpu(), device.queue(), encoder, meshes, &screen);
        let attachment = wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
        };
        let descriptor = wgpu::RenderPassDescriptor { color_attachments: &[Some(attachment)], ..Default::default() };
        let mut pass = encoder.begin_render_pass(&descriptor).forget_lifetime();
        self.renderer.render(&mut pass, meshes, &screen);
    }

    /// Draws the frame once more and writes it to a file.
    fn screenshot(
        &mut self,
        session: &Session,
        meshes: &[egui::ClippedPrimitive],
        scale: f32,
        file: &Path,
    ) -> Result<()> {
        let device = session.device();
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
        self.record(session, frame.encoder(), &view, meshes, scale);
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
        relievo_render::write_png(file, &Image::from_data(width, height, 3, data.collect())?)
    }
}

impl ApplicationHandler for Application {
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
                shown.panels.close(&self.session);
                shown.window.request_redraw();
            }
            WindowEvent::Resized(size) if size.width > 0 && size.height > 0 => {
                (shown.configuration.width, shown.configuration.height) = (size.width, size.height);
                let device = self.session.device();
                if let Err(error) = device.guard(|| shown.surface.configure(device.wgpu(), &shown.configuration)) {
                    self.session.message = Some(error.to_string());
                }
                shown.window.request_redraw();
            }
            WindowEvent::RedrawRequested => match self.frame() {
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
                    let error = match self.session.rescue() {
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
